#include "server/translate/field_violation.h"

#include <catch2/catch.hpp>

#include "motiondb/v1/error.pb.h"

namespace motiondb::server {
namespace {

std::string FieldOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kBadRequestUrl);
  if (!payload.has_value()) return "";
  v1::BadRequest bad_request;
  REQUIRE(bad_request.ParseFromString(std::string(*payload)));
  return bad_request.field_violations(0).field();
}

TEST_CASE("FieldViolation: AtField names the field of errors of content only",
          "[server][translate]") {
  CHECK(FieldOf(AtField("layer", absl::OutOfRangeError("1 to 3"))) == "layer");
  CHECK(AtField("layer", absl::OutOfRangeError("1 to 3")).code() == absl::StatusCode::kOutOfRange);
  CHECK(FieldOf(AtField("file", absl::InvalidArgumentError("x"))) == "file");
  CHECK(FieldOf(AtField("file", absl::InternalError("x"))).empty());
  CHECK(AtField("file", absl::OkStatus()).ok());
}

TEST_CASE("FieldViolation: the first name given stays", "[server][translate]") {
  CHECK(FieldOf(AtField("outer", FieldViolation("inner", "is wrong"))) == "inner");
}

}  // namespace
}  // namespace motiondb::server
