// Checks of statuses in tests; a failure prints the message of the status. A check that passes may
// run on any thread: Catch is called only for one that fails.
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

// Requires that `result` is OK and returns its value.
template <typename T>
T Require(absl::StatusOr<T> result) {
  if (!result.ok()) {
    INFO(result.status().ToString());
    REQUIRE(result.ok());
  }
  return *std::move(result);
}

}  // namespace motiondb::tests

#define REQUIRE_OK(expression)                                                  \
  do {                                                                          \
    const absl::Status required_status = motiondb::tests::StatusOf(expression); \
    if (!required_status.ok()) {                                                \
      INFO(required_status.ToString());                                         \
      REQUIRE(required_status.ok());                                            \
    }                                                                           \
  } while (false)

// Requires an error with this code and with a message that contains the text.
#define REQUIRE_ERROR(expression, expected_code, expected_text)                          \
  do {                                                                                   \
    const absl::Status refused_status = motiondb::tests::StatusOf(expression);           \
    INFO(refused_status.ToString());                                                     \
    REQUIRE(refused_status.code() == (expected_code));                                   \
    REQUIRE_THAT(std::string(refused_status.message()), Catch::Contains(expected_text)); \
  } while (false)
