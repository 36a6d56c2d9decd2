// Errors that name the field of the request that was wrong. The name travels in the absl::Status as
// a payload, a BadRequest under google.rpc's type URL, and reaches the client with it. Safe to call
// from any thread.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::server {

// Type URL of the payload.
inline constexpr char kBadRequestUrl[] = "type.googleapis.com/google.rpc.BadRequest";

// INVALID_ARGUMENT "{field}: {description}".
absl::Status FieldViolation(std::string_view field, std::string_view description);

template <typename... Args>
absl::Status FieldViolation(std::string_view field, fmt::format_string<Args...> format,
                            Args&&... args) requires(sizeof...(Args) > 0) {
  return FieldViolation(field, fmt::format(format, std::forward<Args>(args)...));
}

// An error of the request's content, INVALID_ARGUMENT or OUT_OF_RANGE, with the field it came in.
// Any other status, and one that names its field already, is returned as it is.
absl::Status AtField(std::string_view field, absl::Status status);

}  // namespace motiondb::server
