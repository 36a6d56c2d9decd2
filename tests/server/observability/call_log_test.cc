// What is logged of a call, and how loudly.
#include "server/observability/call_log.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "server/observability/log_formatter.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using nlohmann::json;
using server::CallKind;

// Takes the place of the server's log while it lives.
class CapturedLog {
 public:
  explicit CapturedLog(spdlog::level::level_enum level) : former_(spdlog::default_logger()) {
    auto logger = std::make_shared<spdlog::logger>(
        "captured", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_));
    logger->set_formatter(server::MakeLogFormatter(server::LogFormat::kJson));
    logger->set_level(level);
    spdlog::set_default_logger(logger);
  }
  ~CapturedLog() { spdlog::set_default_logger(former_); }

  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  const std::shared_ptr<spdlog::logger> former_;
};

server::EndedCall SomeCall() {
  return {.method = "QueryService.Recognize",
          .request_id = "7f",
          .peer = "ipv4:127.0.0.1:5",
          .seconds = 0.0123456};
}

constexpr std::chrono::duration<double> kSlow{1};

TEST_CASE("CallLog: an ordinary call is for those who debug", "[server][log]") {
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

TEST_CASE("CallLog: the client's own error is ordinary, the server's is an error",
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
  call.message = "clip 'a' is damaged";
  server::LogCall(call, kSlow);
  const json line = json::parse(log.text());
  CHECK(line["level"] == "error");
  CHECK(line["code"] == "DATA_LOSS");
  CHECK(line["request_id"] == "7f");
  CHECK(line["message"] == "call failed: clip 'a' is damaged");
}

TEST_CASE("CallLog: slow work is a warning, slow waiting is none", "[server][log]") {
  CapturedLog log(spdlog::level::info);
  server::EndedCall call = SomeCall();
  call.seconds = 1;
  for (const CallKind kind : {CallKind::kWait, CallKind::kFrames}) {
    call.kind = kind;
    server::LogCall(call, kSlow);
  }
  call.kind = CallKind::kWork;
  server::LogCall(call, std::chrono::seconds(0));  // none is slow
  CHECK(log.text() == "");
  server::LogCall(call, kSlow);
  const json line = json::parse(log.text());
  CHECK(line["level"] == "warning");
  CHECK(line["message"] == "slow call");
  CHECK(line["milliseconds"] == 1000);
}

}  // namespace
}  // namespace motiondb::tests
