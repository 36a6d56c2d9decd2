// Details of a failed call beside its code and message: request id and retry delay.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace motiondb::client {

// Type URLs of the payloads google.rpc.RequestInfo, google.rpc.RetryInfo and google.rpc.ErrorInfo
// in the absl::Status of a failed call.
inline constexpr absl::string_view kRequestInfoTypeUrl =
    "type.googleapis.com/google.rpc.RequestInfo";
inline constexpr absl::string_view kRetryInfoTypeUrl = "type.googleapis.com/google.rpc.RetryInfo";

inline constexpr absl::string_view kErrorInfoTypeUrl = "type.googleapis.com/google.rpc.ErrorInfo";

// Returns the reason of an error that the server returned, a stable word such as `NO_MODEL`
// (docs/api.md lists them); empty for an error of another origin.
std::string ErrorReason(const absl::Status& status);

// Returns the value of a key of google.rpc.ErrorInfo.metadata, such as "operation" or "takes";
// empty if there is none.
std::string ErrorMetadata(const absl::Status& status, const std::string& key);

// Returns the id of the failed call, as in the server's log; empty if no call was made.
std::string RequestId(const absl::Status& status);

// Returns how long to wait before a retry, or nullopt if the server sent no delay.
std::optional<std::chrono::milliseconds> RetryDelay(const absl::Status& status);

}  // namespace motiondb::client
