// Converts an absl::Status to a grpc::Status, and adds details to errors.
#pragma once

#include <fmt/format.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::server {

// Returns a status with the same canonical code. The message becomes one line of valid UTF-8, at
// most 1 KiB (trailers of gRPC have at most 8 KiB), without display controls and secrets of tokens.
// Payloads become details of a motiondb.v1.Status, in `grpc-status-details-bin`.
grpc::Status ToGrpcStatus(const absl::Status& status);

// Returns the status of a call at another server, with its details.
absl::Status FromGrpcStatus(const grpc::Status& status);

// Details of errors are payloads with type URLs of google.rpc.
inline constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

// Returns RESOURCE_EXHAUSTED with `message` and a RetryInfo of `delay`.
absl::Status RetryLater(std::chrono::milliseconds delay, std::string_view message);

template <typename... Args>
absl::Status RetryLater(std::chrono::milliseconds delay, fmt::format_string<Args...> format,
                        Args&&... args) requires(sizeof...(Args) > 0) {
  return RetryLater(delay, fmt::format(format, std::forward<Args>(args)...));
}

inline constexpr char kRequestInfoUrl[] = "type.googleapis.com/google.rpc.RequestInfo";

// Returns the error with a RequestInfo after its other details.
grpc::Status WithRequestInfo(const grpc::Status& error, const std::string& request_id);

}  // namespace motiondb::server
