#include <catch2/catch.hpp>

#include "core/motion/error.h"

namespace motiondb::core::field_violation_test {
namespace {

std::string FieldOf(const absl::Status& status) {
  const auto payload = status.GetPayload(core::kFieldUrl);
  return payload.has_value() ? std::string(*payload) : "";
}

TEST_CASE("FieldViolation: AtField names the field only for content errors", "[core][motion]") {
  CHECK(FieldOf(AtField("layer", absl::OutOfRangeError("1 to 3"))) == "layer");
  CHECK(AtField("layer", absl::OutOfRangeError("1 to 3")).code() == absl::StatusCode::kOutOfRange);
  CHECK(FieldOf(AtField("file", absl::InvalidArgumentError("x"))) == "file");
  CHECK(FieldOf(AtField("file", absl::InternalError("x"))).empty());
  CHECK(AtField("file", absl::OkStatus()).ok());
}

TEST_CASE("FieldViolation: the first field name is kept", "[core][motion]") {
  CHECK(FieldOf(AtField("outer", FieldViolation("inner", "is wrong"))) == "inner");
}

TEST_CASE("FieldViolation: Within prefixes the field of a part", "[core][motion]") {
  const absl::Status status = Within("prediction", FieldViolation("layer", "expected {}", 1));
  CHECK(status == Within("prediction", FieldViolation("layer", "expected 1")));
  CHECK(FieldOf(status) == "prediction.layer");
  CHECK(status.message() == "prediction.layer: expected 1");
  // A message that does not begin with the field is unchanged.
  const absl::Status of_file = Within("start", AtField("data", InvalidArgument("a.bvh:3: what")));
  CHECK(FieldOf(of_file) == "start.data");
  CHECK(of_file.message() == "a.bvh:3: what");
  // An error without a field gets the part as its field; other codes and OK are unchanged.
  CHECK(FieldOf(Within("start", InvalidArgument("what"))) == "start");
  CHECK(FieldOf(Within("start", absl::NotFoundError("what"))).empty());
  CHECK(Within("start", absl::OkStatus()).ok());
}

}  // namespace
}  // namespace motiondb::core::field_violation_test
