// Limits on calls in flight, for one client and in total, at a real server.
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

// A call of WaitOperation on its own connection: unless it is refused, it stays open until it is
// cancelled.
class OpenWait {
 public:
  OpenWait(const TestServer& server, const std::string& operation, const std::string& request_id)
      : stub_(v1::OperationService::NewStub(server.NewChannel())), end_(ended_.get_future()) {
    request_.set_name(operation);
    request_.mutable_timeout()->set_seconds(600);
    context_.AddMetadata("x-request-id", request_id);
    stub_->async()->WaitOperation(&context_, &request_, &response_,
                                  [this](const grpc::Status& end) { ended_.set_value(end); });
  }
  OpenWait(const OpenWait&) = delete;
  OpenWait& operator=(const OpenWait&) = delete;
  ~OpenWait() {
    context_.TryCancel();
    end_.wait();
  }

  void Cancel() { context_.TryCancel(); }
  bool HasEnded() const { return end_.wait_for(milliseconds(0)) == std::future_status::ready; }
  // Waits for the end of the call and returns its status.
  const grpc::Status& status() const { return end_.get(); }

 private:
  const std::unique_ptr<v1::OperationService::Stub> stub_;
  grpc::ClientContext context_;
  v1::WaitOperationRequest request_;
  v1::WaitOperationResponse response_;
  std::promise<grpc::Status> ended_;
  const std::shared_future<grpc::Status> end_;
};

// Waits until a call has ended and returns its index.
std::size_t AwaitEnd(const std::deque<OpenWait>& waits) {
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (true) {
    for (std::size_t i = 0; i < waits.size(); ++i) {
      if (waits[i].HasEnded()) return i;
    }
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(milliseconds(10));
  }
}

// A server whose next start finds an operation that stays pending during the test.
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

// `two`: limits for two calls. `setting`: the expected name in the error.
void CheckThirdCall(const server::CallLimit& two, const std::string& setting) {
  ServerWithOperation held;
  // Set only now: an ended call may still count for a moment.
  held.server.options().calls.calls = two;
  held.server.Restart();
  std::deque<OpenWait> waits;
  for (int i = 0; i < 3; ++i) {
    waits.emplace_back(held.server, held.operation, "wait-" + std::to_string(i));
  }
  // The last call to arrive; the other two are counted then.
  const std::size_t refused = AwaitEnd(waits);
  CheckRefusal(waits[refused].status(), setting);
  CHECK(DetailOf<v1::RequestInfo>(waits[refused].status(), server::kRequestInfoUrl).request_id() ==
        "wait-" + std::to_string(refused));

  const auto stub = held.server.NewStub<v1::DatabaseService>();
  const auto list = [&] {
    return Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, {}).status;
  };
  CheckRefusal(list(), setting);  // calls of all classes count
  waits[(refused + 1) % 3].Cancel();
  grpc::Status retried = list();
  for (int tries = 0; tries < 3000 && !retried.ok(); ++tries) {
    CheckRefusal(retried, setting);
    std::this_thread::sleep_for(milliseconds(10));
    retried = list();
  }
  INFO(retried.error_message());
  CHECK(retried.ok());
  CHECK(!waits[(refused + 2) % 3].HasEnded());
}

TEST_CASE("Limits: calls above the total limit are refused until one has ended",
          "[server][limits]") {
  CheckThirdCall({.in_all = 2, .per_client = 8}, "--max-calls");
}

TEST_CASE("Limits: calls above the limit of a client are refused until one has ended",
          "[server][limits]") {
  CheckThirdCall({.in_all = 8, .per_client = 2}, "a quarter of --max-calls");
}

}  // namespace
}  // namespace motiondb::tests::open_calls_test
