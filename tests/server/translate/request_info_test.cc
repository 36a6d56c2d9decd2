#include <catch2/catch.hpp>

#include "motiondb/v1/error.pb.h"
#include "server/translate/message_fields.h"
#include "server/translate/status_mapping.h"

namespace motiondb::tests::request_info_test {
namespace {

v1::Status DetailsOf(const grpc::Status& status) {
  v1::Status details;
  REQUIRE(details.ParseFromString(status.error_details()));
  return details;
}

TEST_CASE("RequestInfo: is added after existing details", "[server]") {
  const grpc::Status status = server::WithRequestInfo(
      server::ToGrpcStatus(server::FieldViolation("layer", "too deep")), "robot/1");
  CHECK(status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(status.error_message() == "layer: too deep");
  const v1::Status details = DetailsOf(status);
  CHECK(details.code() == 3);
  REQUIRE(details.details_size() == 3);
  CHECK(details.details(0).type_url() == "type.googleapis.com/google.rpc.ErrorInfo");
  CHECK(details.details(1).type_url() == "type.googleapis.com/google.rpc.BadRequest");
  v1::RequestInfo info;
  CHECK(details.details(2).type_url() == server::kRequestInfoUrl);
  REQUIRE(info.ParseFromString(details.details(2).value()));
  CHECK(info.request_id() == "robot/1");
}

TEST_CASE("RequestInfo: a status without details also gets a reason", "[server]") {
  const v1::Status details =
      DetailsOf(server::WithRequestInfo({grpc::StatusCode::NOT_FOUND, "gone"}, "1"));
  CHECK(details.code() == 5);
  CHECK(details.message() == "gone");
  CHECK(details.details_size() == 2);
}

TEST_CASE("RetryInfo: has the time to wait", "[server]") {
  const absl::Status status = server::RetryLater(std::chrono::milliseconds(1500), "{} calls", 3);
  CHECK(absl::IsResourceExhausted(status));
  CHECK(std::string(status.message()) == "3 calls");
  v1::RetryInfo info;
  REQUIRE(info.ParseFromString(std::string(*status.GetPayload(server::kRetryInfoUrl))));
  CHECK(info.retry_delay().seconds() == 1);
  CHECK(info.retry_delay().nanos() == 500'000'000);
}

}  // namespace
}  // namespace motiondb::tests::request_info_test
