// Streams that stay open are calls that gRPC keeps, as those are that a flood broke off; which it
// forgets when, nobody can say.
#include "server/reset_guard.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "motiondb/v1/observe.grpc.pb.h"
#include "server/connection_figures.h"
#include "tests/support/captured_log.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {
namespace {

using namespace std::chrono_literals;

// A connection with streams that say nothing.
class Streams {
 public:
  Streams(const std::shared_ptr<grpc::Channel>& channel, int count)
      : contexts_(static_cast<std::size_t>(count)) {
    const auto stub = v1::ObserveService::NewStub(channel);
    for (grpc::ClientContext& context : contexts_) {
      context.set_wait_for_ready(true);
      streams_.push_back(stub->Observe(&context));
    }
  }
  ~Streams() {
    for (grpc::ClientContext& context : contexts_) context.TryCancel();
  }
  // Of the first stream, which is over then.
  grpc::Status Finish() { return streams_.front()->Finish(); }

 private:
  std::vector<grpc::ClientContext> contexts_;
  std::vector<std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>>>
      streams_;
};

std::int64_t KeptCalls() {
  std::int64_t kept = 0;
  for (const auto& connection : server::ListConnections()) kept += connection.kept_calls;
  return kept;
}

void AwaitKept(std::int64_t count) {
  const auto latest = std::chrono::steady_clock::now() + 60s;
  while (KeptCalls() != count) {
    INFO(KeptCalls());
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(5ms);
  }
}

// Has a guard look a few times, with a reason: more calls that are not answered with OK than it
// takes calmly.
void Guard(server::CallLimit most, const std::shared_ptr<grpc::Channel>& channel) {
  const server::ResetGuard guard(most);
  for (int i = 0; i < 1100; ++i) REQUIRE(!RawCall(channel, "/no.such/Method", "").status.ok());
  std::this_thread::sleep_for(300ms);
}

TEST_CASE("ResetGuard: ends the connection that keeps most calls, and no other", "[server][rpc]") {
  server::ServerOptions options;
  options.calls.longest_first_silence = 10min;
  TestServer server(options);
  const CapturedLog log(spdlog::level::warn);
  const Streams few(server.NewChannel(), 3);
  AwaitKept(3);
  Streams many(server.NewChannel(), 30);
  AwaitKept(33);
  SECTION("of more than there may be") {
    Guard({.in_all = 20, .per_client = 10}, server.channel());
    AwaitKept(3);
    CHECK(many.Finish().error_code() == grpc::StatusCode::UNAVAILABLE);
    CHECK_THAT(log.text(), Catch::Contains("127.0.0.1:") &&
                               Catch::Contains("its connection is ended: it broke calls off until "
                                               "gRPC kept 30 of them"));
  }
  SECTION("not of as many as there may be") {
    Guard({.in_all = 40, .per_client = 10}, server.channel());
    CHECK(KeptCalls() == 33);
    CHECK(log.text().empty());
  }
  SECTION("not one with as many as a client may have") {
    Guard({.in_all = 20, .per_client = 30}, server.channel());
    CHECK(KeptCalls() == 33);
    CHECK(log.text().empty());
  }
}

}  // namespace
}  // namespace motiondb::tests
