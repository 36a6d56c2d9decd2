// Health, and the drain of a server.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/server/rpc/listed_services.h"
#include "tests/server/rpc/status_of.h"
#include "tests/support/raw_call.h"

namespace motiondb::tests::drain_test {
namespace {

// Waits until `count` calls are in flight, besides the status call itself.
void AwaitOtherCalls(TestServer& server, int count) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (StatusOf(server).open_call_count() != count + 1) {
    REQUIRE(std::chrono::steady_clock::now() < end);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

TEST_CASE("Health: the server and each service are SERVING", "[server][rpc]") {
  TestServer server;
  for (const std::string& service : ListOwnServices(server)) {
    const RawAnswer answer = CheckHealth(server, service);
    INFO(service << ": " << answer.status.error_message());
    CHECK(answer.status.ok());
    CHECK(answer.bytes == kServing);
  }
  CHECK(CheckHealth(server).bytes == kServing);
  CHECK(CheckHealth(server, "none").status.error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("Drain: waiting calls are answered, new ones refused, builds stay pending",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  server.gate().Close();
  const std::string operation = server.IngestFigure("db", "walk", "walk", {}).operation().name();
  server.gate().AwaitArrival();
  AwaitOtherCalls(server, 0);

  grpc::Status waited;
  v1::WaitOperationResponse stood;
  std::thread waiting([&] {
    const auto stub = server.NewStub<v1::OperationService>();
    v1::WaitOperationRequest request;
    request.set_name(operation);
    grpc::ClientContext context;
    waited = stub->WaitOperation(&context, request, &stood);
  });
  AwaitOtherCalls(server, 1);
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(60)); });
  waiting.join();
  CHECK(waited.ok());
  CHECK(!IsDone(stood.operation()));
  server.gate().Open();
  draining.join();
  CHECK(!CheckHealth(server).status.ok());
  server.Restart();
  const v1::Operation done = server.Wait(operation);
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK(done.rebuild().model() == "databases/db/models/1");
}

TEST_CASE("Drain: a call in flight may end, a new one is UNAVAILABLE", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto clips = server.NewStub<v1::ClipService>();
  grpc::ClientContext context;
  v1::IngestClipResponse response;
  const auto writer = clips->IngestClip(&context, &response);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("walk.bvh");
  REQUIRE(writer->Write(message));
  AwaitOtherCalls(server, 1);

  std::thread draining([&] { server.server().Drain(std::chrono::minutes(1)); });
  v1::GetClipRequest request;
  request.set_name("databases/db/clips/walk");
  // NOT_FOUND until the drain begins.
  auto code = grpc::StatusCode::NOT_FOUND;
  for (int tries = 0; tries < 3000 && code == grpc::StatusCode::NOT_FOUND; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    code = Ask(*clips, &v1::ClipService::Stub::GetClip, request).status.error_code();
  }
  CHECK(code == grpc::StatusCode::UNAVAILABLE);
  // Load balancers cannot connect.
  CHECK(CheckHealth(server).status.error_code() == grpc::StatusCode::UNAVAILABLE);

  message.set_file_block(WriteBvh({}));
  REQUIRE(writer->Write(message));
  writer->WritesDone();
  const grpc::Status ended = writer->Finish();
  INFO(ended.error_message());
  CHECK(ended.ok());
  draining.join();
  server.Restart();
  CHECK(server.Wait(response.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
}

TEST_CASE("Drain: a call that does not end is cancelled after the grace period", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto clips = server.NewStub<v1::ClipService>();
  grpc::ClientContext context;
  v1::IngestClipResponse response;
  const auto writer = clips->IngestClip(&context, &response);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("walk.bvh");
  REQUIRE(writer->Write(message));
  AwaitOtherCalls(server, 1);
  const auto began = std::chrono::steady_clock::now();
  server.server().Drain(std::chrono::milliseconds(300));
  CHECK(std::chrono::steady_clock::now() - began < std::chrono::seconds(5));
  CHECK(!writer->Finish().ok());
}

TEST_CASE("Server: an address in use is refused", "[server][rpc]") {
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
}  // namespace motiondb::tests::drain_test
