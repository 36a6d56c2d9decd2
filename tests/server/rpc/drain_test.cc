// Health, and what a server does when it is told to stop.
#include <catch2/catch.hpp>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {
namespace {

// grpc.health.v1.HealthCheckRequest{service = 1} and HealthCheckResponse{status = 1}, by hand: this
// system's packages do not ship the messages.
constexpr char kCheck[] = "/grpc.health.v1.Health/Check";
const std::string kServing("\x08\x01", 2);

std::string ForService(const std::string& service) {
  return service.empty() ? ""
                         : "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
}

TEST_CASE("Health: the server and each of its services serve", "[server][rpc]") {
  TestServer server;
  for (const char* service :
       {"", "motiondb.v1.DatabaseService", "motiondb.v1.ClipService", "motiondb.v1.ModelService",
        "motiondb.v1.OperationService", "motiondb.v1.QueryService"}) {
    const RawAnswer answer = RawCall(server.channel(), kCheck, ForService(service));
    INFO(service << ": " << answer.status.error_message());
    CHECK(answer.status.ok());
    CHECK(answer.bytes == kServing);
  }
  CHECK(RawCall(server.channel(), kCheck, ForService("none")).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("Drain: waiting calls are answered, new ones refused, builds left for later",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  server.gate().Close();
  const std::string operation = server.IngestFigure("db", "walk", "walk", {}).operation().name();
  server.gate().AwaitArrival();

  grpc::Status waited;
  v1::WaitOperationResponse stood;
  std::thread waiting([&] {
    const auto stub = server.NewStub<v1::OperationService>();
    v1::WaitOperationRequest request;
    request.set_name(operation);
    grpc::ClientContext context;
    waited = stub->WaitOperation(&context, request, &stood);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(10)); });
  waiting.join();
  CHECK(waited.ok());
  CHECK(!stood.operation().done());
  server.gate().Open();
  draining.join();
  CHECK(!RawCall(server.channel(), kCheck, "").status.ok());
  server.Restart();
  const v1::Operation done = server.Wait(operation);
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK(done.model() == "databases/db/models/1");
}

TEST_CASE("Server: an address that is taken is refused", "[server][rpc]") {
  TestServer server;
  TemporaryDirectory directory;
  server::ServerOptions options;
  options.listen = server.server().address();
  auto store = storage::SqliteMotionStore::Open(directory / "other.db");
  REQUIRE(store.ok());
  const auto second = server::Server::Start(*std::move(store), options);
  CHECK(absl::IsUnavailable(second.status()));
}

}  // namespace
}  // namespace motiondb::tests
