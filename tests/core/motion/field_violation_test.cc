#include <catch2/catch.hpp>

#include "core/motion/error.h"

namespace motiondb::core::field_violation_test {
namespace {

std::string FieldOf(const absl::Status& status) {
  const auto payload = status.GetPayload(core::kFieldUrl);
  return payload.has_value() ? std::string(*payload) : "";
}

TEST_CASE("FieldViolation: AtField names the field of errors of content only", "[core][motion]") {
  CHECK(FieldOf(AtField("layer", absl::OutOfRangeError("1 to 3"))) == "layer");
  CHECK(AtField("layer", absl::OutOfRangeError("1 to 3")).code() == absl::StatusCode::kOutOfRange);
  CHECK(FieldOf(AtField("file", absl::InvalidArgumentError("x"))) == "file");
  CHECK(FieldOf(AtField("file", absl::InternalError("x"))).empty());
  CHECK(AtField("file", absl::OkStatus()).ok());
}

TEST_CASE("FieldViolation: the first name given stays", "[core][motion]") {
  CHECK(FieldOf(AtField("outer", FieldViolation("inner", "is wrong"))) == "inner");
}

TEST_CASE("FieldViolation: an error of a part is one of the whole", "[core][motion]") {
  const absl::Status status = Within("prediction", FieldViolation("layer", "expected {}", 1));
  CHECK(status == Within("prediction", FieldViolation("layer", "expected 1")));
  CHECK(FieldOf(status) == "prediction.layer");
  CHECK(status.message() == "prediction.layer: expected 1");
  // A message that does not begin with the field stays as it is.
  const absl::Status of_file = Within("start", AtField("data", InvalidArgument("a.bvh:3: what")));
  CHECK(FieldOf(of_file) == "start.data");
  CHECK(of_file.message() == "a.bvh:3: what");
  // One without a field is one of the part; other codes and OK stay.
  CHECK(FieldOf(Within("start", InvalidArgument("what"))) == "start");
  CHECK(FieldOf(Within("start", absl::NotFoundError("what"))).empty());
  CHECK(Within("start", absl::OkStatus()).ok());
}

}  // namespace
}  // namespace motiondb::core::field_violation_test
