// Errors that say when to try again. The time travels as a payload, a RetryInfo under google.rpc's
// type URL, and reaches the client with the status. Safe to call from any thread.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::server {

// Type URL of the payload.
inline constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

// RESOURCE_EXHAUSTED "{message}", to be tried again after `delay`.
absl::Status RetryLater(std::chrono::milliseconds delay, std::string_view message);

template <typename... Args>
absl::Status RetryLater(std::chrono::milliseconds delay, fmt::format_string<Args...> format,
                        Args&&... args) requires(sizeof...(Args) > 0) {
  return RetryLater(delay, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace motiondb::server
