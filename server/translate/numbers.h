// Numbers of a request, checked: NaN, infinity and what lies outside the range is INVALID_ARGUMENT
// that names the field. Safe to call from any thread.
#pragma once

#include <optional>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Positive, or 0 for not given.
absl::StatusOr<std::optional<double>> OptionalPositive(std::string_view field, double value);
// Positive, or 0 for `fallback`.
absl::StatusOr<double> PositiveOr(std::string_view field, double value, double fallback);
absl::StatusOr<double> Positive(std::string_view field, double value);
absl::StatusOr<double> NotNegative(std::string_view field, double value);
absl::StatusOr<double> Finite(std::string_view field, double value);
absl::StatusOr<double> Between(std::string_view field, double value, double least, double most);
absl::StatusOr<double> Probability(std::string_view field, double value);
absl::StatusOr<int> IntegerBetween(std::string_view field, int value, int least, int most);

}  // namespace motiondb::server
