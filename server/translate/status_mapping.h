// The one place where an absl::Status becomes a grpc::Status. Safe to call from any thread.
#pragma once

#include <fmt/format.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::server {

// The same canonical code; the message as one line of valid UTF-8 of at most 1 KiB, without display
// controls and without the secrets of tokens, since gRPC's trailers hold
// 8; payloads as the details of a motiondb.v1.Status, which travels in `grpc-status-details-bin`.
grpc::Status ToGrpcStatus(const absl::Status& status);

// Details of an error beside its message: when to try again, and the id of the call. They travel as
// payloads under google.rpc's type URLs and reach the client with the status. Safe to call from any
// thread.

// Type URL of the payload.
inline constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

// RESOURCE_EXHAUSTED "{message}", to be tried again after `delay`.
absl::Status RetryLater(std::chrono::milliseconds delay, std::string_view message);

template <typename... Args>
absl::Status RetryLater(std::chrono::milliseconds delay, fmt::format_string<Args...> format,
                        Args&&... args) requires(sizeof...(Args) > 0) {
  return RetryLater(delay, fmt::format(format, std::forward<Args>(args)...));
}

inline constexpr char kRequestInfoUrl[] = "type.googleapis.com/google.rpc.RequestInfo";

// The error with a RequestInfo after its other details.
grpc::Status WithRequestInfo(const grpc::Status& error, const std::string& request_id);

}  // namespace motiondb::server
