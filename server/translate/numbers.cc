#include "server/translate/numbers.h"

#include <cmath>

#include "core/motion/error.h"
#include "server/translate/field_violation.h"

namespace motiondb::server {

absl::StatusOr<std::optional<double>> OptionalPositive(std::string_view field, double value) {
  MOTIONDB_ASSIGN_OR_RETURN(const double checked, NotNegative(field, value));
  return checked > 0 ? std::optional<double>(checked) : std::nullopt;
}

absl::StatusOr<double> PositiveOr(std::string_view field, double value, double fallback) {
  MOTIONDB_ASSIGN_OR_RETURN(const double checked, NotNegative(field, value));
  return checked > 0 ? checked : fallback;
}

absl::StatusOr<double> Positive(std::string_view field, double value) {
  if (std::isfinite(value) && value > 0) return value;
  return FieldViolation(field, "expected a positive number, got {}", value);
}

absl::StatusOr<double> NotNegative(std::string_view field, double value) {
  if (std::isfinite(value) && value >= 0) return value;
  return FieldViolation(field, "expected a number that is not negative, got {}", value);
}

absl::StatusOr<double> Finite(std::string_view field, double value) {
  if (std::isfinite(value)) return value;
  return FieldViolation(field, "expected a number, got {}", value);
}

absl::StatusOr<double> Between(std::string_view field, double value, double least, double most) {
  if (value >= least && value <= most) return value;
  return FieldViolation(field, "expected {} to {}, got {}", least, most, value);
}

absl::StatusOr<double> Probability(std::string_view field, double value) {
  if (value >= 0 && value <= 1) return value;
  return FieldViolation(field, "expected a probability, 0 to 1, got {}", value);
}

absl::StatusOr<int> IntegerBetween(std::string_view field, int value, int least, int most) {
  if (value >= least && value <= most) return value;
  return FieldViolation(field, "expected {} to {}, got {}", least, most, value);
}

}  // namespace motiondb::server
