// Statuses in tests: a failure prints its message.
#pragma once

#include <catch2/catch.hpp>
#include <utility>

#include "absl/status/statusor.h"

namespace motiondb::tests {

inline const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

// The value of a result that must be OK.
template <typename T>
T Require(absl::StatusOr<T> result) {
  INFO(result.status().ToString());
  REQUIRE(result.ok());
  return *std::move(result);
}

}  // namespace motiondb::tests

#define REQUIRE_OK(expression)                                                  \
  do {                                                                          \
    const absl::Status required_status = motiondb::tests::StatusOf(expression); \
    INFO(required_status.ToString());                                           \
    REQUIRE(required_status.ok());                                              \
  } while (false)

// The code of an error, and a part of its message.
#define REQUIRE_ERROR(expression, expected_code, expected_text)                          \
  do {                                                                                   \
    const absl::Status refused_status = motiondb::tests::StatusOf(expression);           \
    INFO(refused_status.ToString());                                                     \
    REQUIRE(refused_status.code() == (expected_code));                                   \
    REQUIRE_THAT(std::string(refused_status.message()), Catch::Contains(expected_text)); \
  } while (false)
