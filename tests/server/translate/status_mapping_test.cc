#include "server/translate/status_mapping.h"

#include <catch2/catch.hpp>

#include "motiondb/v1/error.pb.h"
#include "server/translate/message_fields.h"
#include "tests/support/shown_text_cases.h"

namespace motiondb::server::status_mapping_test {
namespace {

// The reason in the google.rpc.ErrorInfo of an error; empty if there is none.
std::string ReasonIn(const grpc::Status& error) {
  v1::Status details;
  if (!details.ParseFromString(error.error_details())) return "(details do not parse)";
  for (const auto& detail : details.details()) {
    v1::ErrorInfo info;
    if (detail.type_url() != "type.googleapis.com/google.rpc.ErrorInfo") continue;
    return info.ParseFromString(detail.value()) && info.domain() == "motiondb" ? info.reason()
                                                                               : "(no ErrorInfo)";
  }
  return "";
}

TEST_CASE("StatusMapping: the reason of an error travels as google.rpc.ErrorInfo",
          "[server][translate]") {
  const absl::Status status =
      core::WithReason("NO_MODEL", core::FailedPrecondition("database 'a' has no model yet"));
  CHECK(ReasonIn(ToGrpcStatus(status)) == "NO_MODEL");
  CHECK(ReasonIn(ToGrpcStatus(core::WithReason("LATER", status))) == "NO_MODEL");
  CHECK(ReasonIn(WithRequestInfo(ToGrpcStatus(status), "1")) == "NO_MODEL");
  CHECK(ReasonIn(WithRequestInfo({grpc::StatusCode::UNAVAILABLE, "gone"}, "1")) == "UNAVAILABLE");
}

TEST_CASE("StatusMapping: resource names become metadata of google.rpc.ErrorInfo",
          "[server][translate]") {
  const grpc::Status mapped = ToGrpcStatus(core::WithResource(
      "operation", "operations/7", core::WithReason("MODEL_BUILDING", absl::UnknownError("x"))));
  v1::Status details;
  REQUIRE(details.ParseFromString(mapped.error_details()));
  REQUIRE(details.details_size() == 1);
  v1::ErrorInfo info;
  REQUIRE(info.ParseFromString(details.details(0).value()));
  CHECK(info.reason() == "MODEL_BUILDING");
  REQUIRE(info.metadata_size() == 1);
  CHECK(info.metadata().at("operation") == "operations/7");
  CHECK(core::WithResource("clip", "x", absl::OkStatus()).ok());
}

TEST_CASE("StatusMapping: every canonical code keeps its number", "[server][translate]") {
  for (int code = 0; code <= 16; ++code) {
    const absl::Status status(static_cast<absl::StatusCode>(code), "why");
    const grpc::Status mapped = ToGrpcStatus(status);
    CHECK(static_cast<int>(mapped.error_code()) == code);
    CHECK(mapped.error_message() == (code == 0 ? "" : "why"));
    CHECK(ReasonIn(mapped) == (code == 0 ? "" : absl::StatusCodeToString(status.code())));
  }
  CHECK(ToGrpcStatus(absl::Status(static_cast<absl::StatusCode>(99), "odd")).error_code() ==
        grpc::StatusCode::UNKNOWN);
}

TEST_CASE("StatusMapping: a field violation becomes google.rpc.BadRequest", "[server][translate]") {
  const grpc::Status mapped =
      ToGrpcStatus(FieldViolation("observation.markers.frame_rate_hz", "must be {}", "positive"));
  CHECK(mapped.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(mapped.error_message() == "observation.markers.frame_rate_hz: must be positive");
  v1::Status details;
  REQUIRE(details.ParseFromString(mapped.error_details()));
  CHECK(details.code() == 3);
  CHECK(details.message() == mapped.error_message());
  REQUIRE(details.details_size() == 2);
  CHECK(ReasonIn(mapped) == "INVALID_FIELD");
  CHECK(details.details(1).type_url() == "type.googleapis.com/google.rpc.BadRequest");
  v1::BadRequest bad_request;
  REQUIRE(bad_request.ParseFromString(details.details(1).value()));
  REQUIRE(bad_request.field_violations_size() == 1);
  CHECK(bad_request.field_violations(0).field() == "observation.markers.frame_rate_hz");
  CHECK(bad_request.field_violations(0).description() == "must be positive");
}

TEST_CASE("StatusMapping: messages fit gRPC's trailers and are UTF-8", "[server][translate]") {
  const grpc::Status mapped = ToGrpcStatus(FieldViolation("field", std::string(100'000, '\xff')));
  CHECK(mapped.error_message().size() <= 1024);
  // Trailers are limited to 8 KiB: the message percent-encoded, the details in base64.
  CHECK(3 * mapped.error_message().size() + mapped.error_details().size() * 4 / 3 < 8000);
  v1::Status details;
  CHECK(details.ParseFromString(mapped.error_details()));
}

TEST_CASE("StatusMapping: messages and details have no secrets and no display controls",
          "[server][translate]") {
  for (const auto& [text, shown] : tests::DisplayedTextCases()) {
    CAPTURE(text);
    const grpc::Status mapped = ToGrpcStatus(FieldViolation("field", "got '{}'", text));
    CHECK(mapped.error_message() == "field: got '" + shown + "'");
    v1::Status details;
    REQUIRE(details.ParseFromString(mapped.error_details()));
    v1::BadRequest bad_request;
    REQUIRE(bad_request.ParseFromString(details.details(1).value()));
    CHECK(bad_request.field_violations(0).description() == "got '" + shown + "'");
  }
}

}  // namespace
}  // namespace motiondb::server::status_mapping_test
