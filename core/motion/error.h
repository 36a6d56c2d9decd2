// absl::Status errors with formatted messages, and the macros that propagate them. (fmt rather than
// absl::StrCat: Debian's absl does not accept std::string_view.)
//
// An error about one argument carries the argument's name in a payload, so that the client receives
// it as a field violation.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"

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

// Type URL of the payload with the field name.
inline constexpr char kFieldUrl[] = "motiondb.field";

// Adds the field name to INVALID_ARGUMENT or OUT_OF_RANGE. Returns other statuses, and errors that
// already have a field name, unchanged.
inline absl::Status AtField(std::string_view field, absl::Status status) {
  const bool of_content = absl::IsInvalidArgument(status) || absl::IsOutOfRange(status);
  if (of_content && !status.GetPayload(kFieldUrl).has_value()) {
    status.SetPayload(kFieldUrl, absl::Cord(std::string(field)));
  }
  return status;
}

// Type URL of the payload that holds the reason of an error.
inline constexpr char kReasonUrl[] = "motiondb.reason";

// Adds a stable reason in UPPER_SNAKE_CASE, by which a program tells failures of one code apart; it
// reaches clients as google.rpc.ErrorInfo. docs/api.md lists the reasons. A status with a reason is
// returned as it is.
inline absl::Status WithReason(std::string_view reason, absl::Status status) {
  if (!status.ok() && !status.GetPayload(kReasonUrl).has_value()) {
    status.SetPayload(kReasonUrl, absl::Cord(std::string(reason)));
  }
  return status;
}

// Prefix of the type URL of a payload that holds one entry of google.rpc.ErrorInfo.metadata.
inline constexpr std::string_view kMetadataUrl = "motiondb.metadata/";

// Adds the resource name that a program needs to react to the error, for example the operation to
// wait for. `key`: the kind of resource, in lower case.
inline absl::Status WithResource(std::string_view key, std::string_view name, absl::Status status) {
  if (!status.ok()) {
    status.SetPayload(fmt::format("{}{}", kMetadataUrl, key), absl::Cord(std::string(name)));
  }
  return status;
}

// Returns INVALID_ARGUMENT "{field}: {description}" with the field name.
inline absl::Status FieldViolation(std::string_view field, std::string_view description) {
  return AtField(field, InvalidArgument("{}: {}", field, description));
}

template <typename... Args>
absl::Status FieldViolation(std::string_view field, fmt::format_string<Args...> format,
                            Args&&... args) requires(sizeof...(Args) > 0) {
  return FieldViolation(field, fmt::format(format, std::forward<Args>(args)...));
}

// Converts an error about a submessage to one about its parent: prefixes the field name, if any,
// with `part.`.
inline absl::Status Within(std::string_view part, const absl::Status& status) {
  const auto field = status.GetPayload(kFieldUrl);
  if (!field.has_value()) return AtField(part, status);
  std::string message(status.message());
  if (message.starts_with(std::string(*field))) message = fmt::format("{}.{}", part, message);
  absl::Status outer(status.code(), message);
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { outer.SetPayload(url, payload); });
  outer.SetPayload(kFieldUrl, absl::Cord(fmt::format("{}.{}", part, std::string(*field))));
  return outer;
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

// MOTIONDB_ASSIGN_OR_RETURN(auto x, F()): assigns F()'s value to x, or returns F()'s error.
#define MOTIONDB_ASSIGN_OR_RETURN(declaration, expression) \
  MOTIONDB_ASSIGN_OR_RETURN_INNER(MOTIONDB_JOIN(motiondb_or_, __LINE__), declaration, expression)
#define MOTIONDB_ASSIGN_OR_RETURN_INNER(result, declaration, expression) \
  auto result = (expression);                                            \
  if (!result.ok()) return std::move(result).status();                   \
  declaration = *std::move(result)
