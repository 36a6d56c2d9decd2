// What else an error of a call says, beside its code and message: the call's id, and when to try
// again. Functions here are pure, safe on any thread.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace motiondb::client {

// Under these type URLs a failed call's absl::Status carries a google.rpc.RequestInfo,
// google.rpc.RetryInfo and google.rpc.ErrorInfo as payload.
inline constexpr absl::string_view kRequestInfoTypeUrl =
    "type.googleapis.com/google.rpc.RequestInfo";
inline constexpr absl::string_view kRetryInfoTypeUrl = "type.googleapis.com/google.rpc.RetryInfo";

inline constexpr absl::string_view kErrorInfoTypeUrl = "type.googleapis.com/google.rpc.ErrorInfo";

// Returns the reason of an error that the server returned, a stable word such as `NO_MODEL`
// (docs/api.md lists them); empty for an error of another origin.
std::string ErrorReason(const absl::Status& status);

// The id of the call that failed, by which the server's log has it if it came there; empty where no
// call was made.
std::string RequestId(const absl::Status& status);

// How long to wait before the same call is tried again; nothing where the server does not say.
std::optional<std::chrono::milliseconds> RetryDelay(const absl::Status& status);

}  // namespace motiondb::client
