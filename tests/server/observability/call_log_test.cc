// Content and level of log lines about calls.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "server/observability/monitor.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::call_log_test {
namespace {

using absl::StatusCode;
using nlohmann::json;
using server::CallKind;

server::EndedCall SomeCall() {
  return {.method = "QueryService.Recognize",
          .request_id = "7f",
          .peer = "ipv4:127.0.0.1:5",
          .seconds = 0.0123456};
}

constexpr std::chrono::duration<double> kSlow{1};

TEST_CASE("CallLog: an ordinary call is logged at level debug", "[server][log]") {
  CapturedLog quiet(spdlog::level::info);
  server::LogCall(SomeCall(), kSlow);
  CHECK(quiet.text() == "");

  CapturedLog log(spdlog::level::debug);
  server::LogCall(SomeCall(), kSlow);
  const json line = json::parse(log.text());
  CHECK(line["level"] == "debug");
  CHECK(line["request_id"] == "7f");
  CHECK(line["method"] == "QueryService.Recognize");
  CHECK(line["code"] == "OK");
  CHECK(line["milliseconds"] == 12.346);
  CHECK(line["peer"] == "ipv4:127.0.0.1:5");
}

TEST_CASE("CallLog: a client error is an ordinary call, a server error is logged as an error",
          "[server][log]") {
  CapturedLog log(spdlog::level::info);
  server::EndedCall call = SomeCall();
  for (const StatusCode theirs : {StatusCode::kNotFound, StatusCode::kInvalidArgument,
                                  StatusCode::kCancelled, StatusCode::kUnauthenticated}) {
    call.code = theirs;
    server::LogCall(call, kSlow);
  }
  CHECK(log.text() == "");
  call.code = StatusCode::kDataLoss;
  call.message = "clip 'a' is corrupt";
  server::LogCall(call, kSlow);
  const json line = json::parse(log.text());
  CHECK(line["level"] == "error");
  CHECK(line["code"] == "DATA_LOSS");
  CHECK(line["request_id"] == "7f");
  CHECK(line["message"] == "call failed: clip 'a' is corrupt");
}

TEST_CASE("CallLog: slow work is a warning, a long wait is not", "[server][log]") {
  CapturedLog log(spdlog::level::info);
  server::EndedCall call = SomeCall();
  call.seconds = 1;
  for (const CallKind kind : {CallKind::kWait, CallKind::kFrames}) {
    call.kind = kind;
    server::LogCall(call, kSlow);
  }
  call.kind = CallKind::kWork;
  server::LogCall(call, std::chrono::seconds(0));  // 0: no call is slow
  CHECK(log.text() == "");
  server::LogCall(call, kSlow);
  const json line = json::parse(log.text());
  CHECK(line["level"] == "warning");
  CHECK(line["message"] == "slow call");
  CHECK(line["milliseconds"] == 1000);
}

}  // namespace
}  // namespace motiondb::tests::call_log_test
