// Calls at a time, of one client and in all, at a real server.
#include <catch2/catch.hpp>
#include <chrono>
#include <deque>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::open_calls_test {
namespace {

using std::chrono::milliseconds;

// A wait for an operation that lasts, over a connection of its own: a call that stands until it is
// cancelled, if it was not refused.
class StandingWait {
 public:
  StandingWait(const TestServer& server, const std::string& operation,
               const std::string& request_id)
      : stub_(v1::OperationService::NewStub(server.NewChannel())), end_(ended_.get_future()) {
    request_.set_name(operation);
    request_.mutable_timeout()->set_seconds(600);
    context_.AddMetadata("x-request-id", request_id);
    stub_->async()->WaitOperation(&context_, &request_, &response_,
                                  [this](const grpc::Status& end) { ended_.set_value(end); });
  }
  StandingWait(const StandingWait&) = delete;
  StandingWait& operator=(const StandingWait&) = delete;
  ~StandingWait() {
    context_.TryCancel();
    end_.wait();
  }

  void Cancel() { context_.TryCancel(); }
  bool HasEnded() const { return end_.wait_for(milliseconds(0)) == std::future_status::ready; }
  // What it came to. Waits until it has ended.
  const grpc::Status& status() const { return end_.get(); }

 private:
  const std::unique_ptr<v1::OperationService::Stub> stub_;
  grpc::ClientContext context_;
  v1::WaitOperationRequest request_;
  v1::WaitOperationResponse response_;
  std::promise<grpc::Status> ended_;
  const std::shared_future<grpc::Status> end_;
};

// The index of one that has ended, when there is one.
std::size_t AwaitEnd(const std::deque<StandingWait>& waits) {
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (true) {
    for (std::size_t i = 0; i < waits.size(); ++i) {
      if (waits[i].HasEnded()) return i;
    }
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(milliseconds(10));
  }
}

// A server whose next start finds an operation that stays undone for as long as a test may last.
struct ServerWithOperation {
  ServerWithOperation() : server(SlowToRebuild()) {
    server.CreateDatabase("db");
    operation = server.IngestFigure("db", "walk", "walk", {}).operation().name();
  }
  static server::ServerOptions SlowToRebuild() {
    server::ServerOptions options = With({});
    options.engine.rebuild_delay = options.engine.rebuild_delay_limit = std::chrono::minutes(10);
    return options;
  }

  TestServer server;
  std::string operation;
};

// With room for two calls, under the setting named.
void CheckThirdCall(const server::CallLimit& two, const std::string& setting) {
  ServerWithOperation held;
  // Only now: a call that has ended may keep its place for a moment, and would be in the way.
  held.server.options().calls.calls = two;
  held.server.Restart();
  std::deque<StandingWait> waits;
  for (int i = 0; i < 3; ++i) {
    waits.emplace_back(held.server, held.operation, "wait-" + std::to_string(i));
  }
  // Whichever came last: the other two have their places then.
  const std::size_t refused = AwaitEnd(waits);
  CheckRefusal(waits[refused].status(), setting);
  CHECK(DetailOf<v1::RequestInfo>(waits[refused].status(), server::kRequestInfoUrl).request_id() ==
        "wait-" + std::to_string(refused));

  const auto stub = held.server.NewStub<v1::DatabaseService>();
  const auto list = [&] {
    return Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, {}).status;
  };
  CheckRefusal(list(), setting);  // calls of all kinds are counted together
  waits[(refused + 1) % 3].Cancel();
  grpc::Status again = list();
  for (int tries = 0; tries < 3000 && !again.ok(); ++tries) {
    CheckRefusal(again, setting);
    std::this_thread::sleep_for(milliseconds(10));
    again = list();
  }
  INFO(again.error_message());
  CHECK(again.ok());
  CHECK(!waits[(refused + 2) % 3].HasEnded());
}

TEST_CASE("Limits: more calls in all than there may be are refused, until one has ended",
          "[server][limits]") {
  CheckThirdCall({.in_all = 2, .per_client = 8}, "--max-calls");
}

TEST_CASE("Limits: more calls of a client than there may be are refused, until one has ended",
          "[server][limits]") {
  CheckThirdCall({.in_all = 8, .per_client = 2}, "a quarter of --max-calls");
}

}  // namespace
}  // namespace motiondb::tests::open_calls_test
