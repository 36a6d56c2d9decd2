// Errors as values: absl::Status with a formatted message, and the two macros that pass one
// upwards. (fmt rather than absl::StrCat: Debian's absl does not accept std::string_view.)
#pragma once

#include <fmt/format.h>

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::core {

template <typename... Args>
absl::Status InvalidArgument(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
absl::Status NotFound(fmt::format_string<Args...> format, Args&&... args) {
  return absl::NotFoundError(fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
absl::Status FailedPrecondition(fmt::format_string<Args...> format, Args&&... args) {
  return absl::FailedPreconditionError(fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
absl::Status DataLoss(fmt::format_string<Args...> format, Args&&... args) {
  return absl::DataLossError(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace motiondb::core

#define MOTIONDB_JOIN_INNER(a, b) a##b
#define MOTIONDB_JOIN(a, b) MOTIONDB_JOIN_INNER(a, b)

// Returns from the enclosing function if `expression` is an error.
#define MOTIONDB_RETURN_IF_ERROR(expression)                                \
  if (absl::Status motiondb_status = (expression); !motiondb_status.ok()) { \
    return motiondb_status;                                                 \
  }                                                                         \
  static_assert(true)

// MOTIONDB_ASSIGN_OR_RETURN(auto x, F()): x is F()'s value, or F()'s error is returned.
#define MOTIONDB_ASSIGN_OR_RETURN(declaration, expression) \
  MOTIONDB_ASSIGN_OR_RETURN_INNER(MOTIONDB_JOIN(motiondb_or_, __LINE__), declaration, expression)
#define MOTIONDB_ASSIGN_OR_RETURN_INNER(result, declaration, expression) \
  auto result = (expression);                                            \
  if (!result.ok()) return std::move(result).status();                   \
  declaration = *std::move(result)
