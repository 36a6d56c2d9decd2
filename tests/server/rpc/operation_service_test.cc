#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/model.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::operation_service_test {
namespace {

using Stub = v1::OperationService::Stub;

// A server with a build that is blocked by the gate of the test.
struct BlockedBuild {
  BlockedBuild() {
    server.CreateDatabase("db");
    server.gate().Close();
    operation = server.IngestFigure("db", "walk", "walk", {}).operation().name();
    server.gate().AwaitArrival();
    stub = server.NewStub<v1::OperationService>();
  }
  Answer<v1::WaitOperationResponse> Wait(int milliseconds) {
    v1::WaitOperationRequest request;
    request.set_name(operation);
    request.mutable_timeout()->set_nanos(milliseconds * 1'000'000);
    return Ask(*stub, &Stub::WaitOperation, request);
  }

  TestServer server;
  std::string operation;
  std::unique_ptr<Stub> stub;
};

TEST_CASE("OperationService: an operation can be watched from start to end", "[server][rpc]") {
  BlockedBuild held;
  v1::GetOperationRequest get;
  get.set_name(held.operation);
  const auto running = Ask(*held.stub, &Stub::GetOperation, get);
  REQUIRE(running.status.ok());
  CHECK(running.response.operation().state() == v1::OPERATION_STATE_RUNNING);
  CHECK(running.response.operation().stage() == "reading clips");
  CHECK(!IsDone(running.response.operation()));
  held.server.gate().Open();
  const auto done = held.server.Wait(held.operation);
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK(IsDone(done));
  CHECK(done.progress() == 1);
  CHECK(done.rebuild().model() == "databases/db/models/1");
  CHECK(done.update_time().seconds() >= done.create_time().seconds());
}

TEST_CASE("OperationService: a wait ends at its timeout", "[server][rpc]") {
  BlockedBuild held;
  const auto began = std::chrono::steady_clock::now();
  const auto answer = held.Wait(200);
  REQUIRE(answer.status.ok());
  CHECK(answer.response.operation().state() == v1::OPERATION_STATE_RUNNING);
  CHECK(std::chrono::steady_clock::now() - began >= std::chrono::milliseconds(200));
  CHECK(held.Wait(0).status.ok());
}

TEST_CASE("OperationService: a wait without a timeout responds before the deadline",
          "[server][rpc]") {
  BlockedBuild held;
  v1::WaitOperationRequest request;
  request.set_name(held.operation);
  v1::WaitOperationResponse response;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(1));
  const grpc::Status status = held.stub->WaitOperation(&context, request, &response);
  INFO(status.error_message());
  CHECK(status.ok());
  CHECK(!IsDone(response.operation()));
}

TEST_CASE("OperationService: many clients can wait for one operation without a thread each",
          "[server][rpc]") {
  BlockedBuild held;
  std::vector<std::thread> waiting;
  std::atomic<int> succeeded{0};
  for (int i = 0; i < 16; ++i) {
    waiting.emplace_back([&] {
      v1::WaitOperationRequest request;
      request.set_name(held.operation);
      const auto answer = Ask(*held.stub, &Stub::WaitOperation, request);
      succeeded += answer.response.operation().state() == v1::OPERATION_STATE_SUCCEEDED ? 1 : 0;
    });
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  CHECK(held.server.Describe("db").model_version() == 0);  // other calls are served
  held.server.gate().Open();
  for (std::thread& thread : waiting) thread.join();
  CHECK(succeeded == 16);
}

TEST_CASE("OperationService: a waiting call can be cancelled by its client", "[server][rpc]") {
  BlockedBuild held;
  grpc::ClientContext context;
  std::thread cancelling([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    context.TryCancel();
  });
  v1::WaitOperationRequest request;
  request.set_name(held.operation);
  v1::WaitOperationResponse response;
  CHECK(held.stub->WaitOperation(&context, request, &response).error_code() ==
        grpc::StatusCode::CANCELLED);
  cancelling.join();
}

TEST_CASE("OperationService: cancels, and refuses with a reason if it cannot", "[server][rpc]") {
  BlockedBuild held;
  v1::CancelOperationRequest cancel;
  cancel.set_name(held.operation);
  CHECK(Ask(*held.stub, &Stub::CancelOperation, cancel).status.ok());
  held.server.gate().Open();
  const v1::Operation ended = held.server.Wait(held.operation);
  CHECK(ended.state() == v1::OPERATION_STATE_CANCELLED);
  CHECK(ended.error().code() == static_cast<int>(grpc::StatusCode::CANCELLED));
  v1::GetModelRequest get;
  get.set_name("databases/db/models/current");
  const auto models = held.server.NewStub<v1::ModelService>();
  grpc::Status no_model;
  do {  // the cancelled build ends soon
    no_model = Ask(*models, &v1::ModelService::Stub::GetModel, get).status;
  } while (ReasonOf(no_model) == "MODEL_BUILDING");
  CHECK(ReasonOf(no_model) == "NO_MODEL");
  CHECK_THAT(no_model.error_message(), Catch::Contains("motiondb reprocess db"));
  CHECK(IsDone(Ask(*held.stub, &Stub::CancelOperation, cancel).response.operation()));
  cancel.set_name("operations/none");
  CHECK(Ask(*held.stub, &Stub::CancelOperation, cancel).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
  cancel.set_name("none");
  CHECK(ViolatedFields(Ask(*held.stub, &Stub::CancelOperation, cancel).status) == "name");
}

TEST_CASE("OperationService: invalid waits are refused", "[server][rpc]") {
  BlockedBuild held;
  CHECK(ViolatedFields(held.Wait(-5).status) == "timeout");
  v1::WaitOperationRequest request;
  request.set_name("operations/none");
  CHECK(Ask(*held.stub, &Stub::WaitOperation, request).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
  request.set_name("none");
  CHECK(ViolatedFields(Ask(*held.stub, &Stub::WaitOperation, request).status) == "name");
}

TEST_CASE("OperationService: lists newest first, for one database or all", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("a");
  server.CreateTrained("b");
  const auto stub = server.NewStub<v1::OperationService>();
  v1::ListOperationsRequest request;
  request.set_page_size(1);
  const auto first = Ask(*stub, &Stub::ListOperations, request);
  REQUIRE(first.status.ok());
  REQUIRE(first.response.operations_size() == 1);
  CHECK(first.response.operations(0).database() == "databases/b");
  request.set_page_token(first.response.next_page_token());
  CHECK(Ask(*stub, &Stub::ListOperations, request).status.ok());
  request.set_parent("databases/a");
  CHECK(ViolatedFields(Ask(*stub, &Stub::ListOperations, request).status) == "page_token");
  request.clear_page_token();
  CHECK(Ask(*stub, &Stub::ListOperations, request).response.operations(0).database() ==
        "databases/a");
  request.set_parent("databases/none");
  CHECK(Ask(*stub, &Stub::ListOperations, request).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace motiondb::tests::operation_service_test
