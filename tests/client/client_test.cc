#include <motiondb/client.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/error.pb.h>
#include <motiondb/v1/model.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <motiondb/v1/plan.pb.h>
#include <motiondb/v1/query.pb.h>
#include <motiondb/v1/view.pb.h>

#include <catch2/catch.hpp>
#include <thread>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"

namespace motiondb::tests::client_test {
namespace {

using client::CallOptions;
using client::Client;
using client::ClientOptions;

// Returns grpc-status-details-bin with a field violation.
std::string Details(const std::string& field, const std::string& description) {
  v1::BadRequest bad_request;
  auto* violation = bad_request.add_field_violations();
  violation->set_field(field);
  violation->set_description(description);
  v1::Status status;
  status.set_code(3);
  auto* detail = status.add_details();
  detail->set_type_url("type.googleapis.com/google.rpc.BadRequest");
  detail->set_value(bad_request.SerializeAsString());
  return status.SerializeAsString();
}

TEST_CASE("Client: a unary call sends its request and returns the response", "[client]") {
  FakeServer server;
  v1::RecognizeResponse answer;
  answer.add_windows()->set_familiarity(0.5);
  server.Answer("Recognize", answer);
  const Client client = ConnectTo(server.address());
  v1::RecognizeRequest request;
  request.set_database("databases/walks");
  request.set_window_seconds(0.4);
  const auto response = client.Recognize(request);
  REQUIRE(response.ok());
  CHECK(response->windows(0).familiarity() == 0.5);
  const auto seen = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(seen.size() == 1);
  CHECK(seen[0].SerializeAsString() == request.SerializeAsString());
}

TEST_CASE("Client: an error has the code, the message and the wrong fields", "[client]") {
  FakeServer server;
  server.Fail("Estimate", 3, "the observation cannot be used",
              Details("observation.markers.frame_rate_hz", "must be positive"));
  const Client client = ConnectTo(server.address());
  const absl::Status status = client.Estimate({}).status();
  CHECK(status.code() == absl::StatusCode::kInvalidArgument);
  CHECK(std::string(status.message()) ==
        "the observation cannot be used; observation.markers.frame_rate_hz: must be positive");
  const auto violations = client::FieldViolations(status);
  REQUIRE(violations.size() == 1);
  CHECK(violations[0].field == "observation.markers.frame_rate_hz");
  CHECK(violations[0].description == "must be positive");
}

TEST_CASE("Client: a field in the message is not repeated", "[client]") {
  FakeServer server;
  server.Fail("Estimate", 3, "layer: must be at most 16", Details("layer", "must be at most 16"));
  const Client client = ConnectTo(server.address());
  const absl::Status status = client.Estimate({}).status();
  CHECK(std::string(status.message()) == "layer: must be at most 16");
  CHECK(client::FieldViolations(status).size() == 1);
}

TEST_CASE("Client: an error without details or with invalid details", "[client]") {
  FakeServer server;
  server.Fail("Predict", 9, "the database has no model yet; ingest a clip");
  server.Fail("Predict", 5, "no such database", "\xFF\xFF not a message");
  const Client client = ConnectTo(server.address());
  const absl::Status first = client.Predict({}).status();
  CHECK(first.code() == absl::StatusCode::kFailedPrecondition);
  CHECK(std::string(first.message()) == "the database has no model yet; ingest a clip");
  CHECK(client::FieldViolations(first).empty());
  const absl::Status second = client.Predict({}).status();
  CHECK(second.code() == absl::StatusCode::kNotFound);
  CHECK(std::string(second.message()) == "no such database");
}

TEST_CASE("Client: without a server, UNAVAILABLE with the address within the connect timeout",
          "[client]") {
  ClientOptions options;
  options.server = "127.0.0.1:1";
  options.connect_timeout = std::chrono::milliseconds(300);
  const absl::Status status = Client::Connect(options).status();
  CHECK(status.code() == absl::StatusCode::kUnavailable);
  CHECK_THAT(std::string(status.message()),
             Catch::Contains("127.0.0.1:1") && Catch::Contains("motiondbd"));
}

TEST_CASE("Client: a stopped server is UNAVAILABLE immediately", "[client]") {
  auto server = std::make_unique<FakeServer>();
  const std::string address = server->address();
  const Client client = ConnectTo(address);
  server.reset();
  const absl::Status status = client.GetDatabase({}).status();
  CHECK(status.code() == absl::StatusCode::kUnavailable);
  CHECK_THAT(std::string(status.message()), Catch::Contains(address));
  CHECK(!client::RequestId(status).empty());
}

TEST_CASE("Client: a call that the server cancels is UNAVAILABLE", "[client]") {
  FakeServer server;
  server.Fail("GetDatabase", 1, "CANCELLED");
  const Client client = ConnectTo(server.address());
  const absl::Status status = client.GetDatabase({}).status();
  CHECK(status.code() == absl::StatusCode::kUnavailable);
  CHECK_THAT(std::string(status.message()), Catch::Contains("was cancelled"));
}

TEST_CASE("Client: invalid options are refused", "[client]") {
  ClientOptions options;
  options.server = "";
  CHECK(Client::Connect(options).status().code() == absl::StatusCode::kInvalidArgument);
  options = {};
  options.call_timeout = std::chrono::milliseconds(0);
  CHECK(Client::Connect(options).status().code() == absl::StatusCode::kInvalidArgument);
}

TEST_CASE("Client: a call ends at its deadline", "[client]") {
  FakeServer server;
  server.Push("GetModel", {0, "", "", {}, 2000});
  const Client client = ConnectTo(server.address());
  const absl::Status status =
      client.GetModel({}, CallOptions{.timeout = std::chrono::milliseconds(100)}).status();
  CHECK(status.code() == absl::StatusCode::kDeadlineExceeded);
  CHECK_THAT(std::string(status.message()),
             Catch::Contains(server.address()) && Catch::Contains("0.1 s"));
  // The server logs the call with this id, although its response was too late.
  const std::string sent = server.HeadersOf("GetModel").at(0).at("x-request-id");
  CHECK(client::RequestId(status) == sent);
  CHECK_THAT(std::string(status.message()), Catch::Contains("(request " + sent + ")"));
}

TEST_CASE("Client: whole lists follow the page tokens", "[client]") {
  FakeServer server;
  v1::ListDatabasesResponse first, second;
  first.add_databases()->set_name("databases/a");
  first.add_databases()->set_name("databases/b");
  first.set_next_page_token("more");
  second.add_databases()->set_name("databases/c");
  server.Answer("ListDatabases", first);
  server.Answer("ListDatabases", second);
  const Client client = ConnectTo(server.address());
  const auto all = client.AllDatabases();
  REQUIRE(all.ok());
  REQUIRE(all->size() == 3);
  CHECK((*all)[2].name() == "databases/c");
  const auto requests = server.Requests<v1::ListDatabasesRequest>("ListDatabases");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].page_token().empty());
  CHECK(requests[1].page_token() == "more");
}

TEST_CASE("Client: a repeated page token is an error", "[client]") {
  FakeServer server;
  v1::ListNodesResponse page;
  page.add_nodes();
  page.set_next_page_token("same");
  server.Answer("ListNodes", page);
  const Client client = ConnectTo(server.address());
  CHECK(client.AllNodes({}).status().code() == absl::StatusCode::kInternal);
}

TEST_CASE("Client: waiting polls until the operation is done and reports progress", "[client]") {
  FakeServer server;
  for (const double progress : {0.0, 0.5, 1.0}) {
    v1::WaitOperationResponse response;
    response.mutable_operation()->set_name("operations/7");
    response.mutable_operation()->set_progress(progress);
    response.mutable_operation()->set_state(progress == 1.0 ? v1::OPERATION_STATE_SUCCEEDED
                                                            : v1::OPERATION_STATE_RUNNING);
    server.Answer("WaitOperation", response);
  }
  const Client client = ConnectTo(server.address());
  std::vector<double> seen;
  const auto done = client.WaitOperation(
      "operations/7", [&](const v1::Operation& now) { seen.push_back(now.progress()); });
  REQUIRE(done.ok());
  CHECK(seen == std::vector<double>{0.0, 0.5, 1.0});
  CHECK(client::OperationStatus(*done).ok());
  const auto requests = server.Requests<v1::WaitOperationRequest>("WaitOperation");
  REQUIRE(requests.size() == 3);
  CHECK(requests[0].name() == "operations/7");
  CHECK(requests[0].has_timeout());
}

TEST_CASE("Client: waiting ends at its timeout", "[client]") {
  FakeServer server;
  v1::WaitOperationResponse running;
  running.mutable_operation()->set_state(v1::OPERATION_STATE_RUNNING);
  server.Push("WaitOperation", {0, "", "", {running.SerializeAsString()}, 20});
  const Client client = ConnectTo(server.address());
  const auto done = client.WaitOperation("operations/7", {},
                                         CallOptions{.timeout = std::chrono::milliseconds(100)});
  CHECK(done.status().code() == absl::StatusCode::kDeadlineExceeded);
}

TEST_CASE("Client: OperationStatus of each state", "[client]") {
  v1::Operation operation;
  operation.set_name("operations/7");
  operation.set_state(v1::OPERATION_STATE_RUNNING);
  CHECK(client::OperationStatus(operation).code() == absl::StatusCode::kFailedPrecondition);
  operation.set_state(v1::OPERATION_STATE_CANCELLED);
  CHECK(client::OperationStatus(operation).code() == absl::StatusCode::kCancelled);
  operation.set_state(v1::OPERATION_STATE_FAILED);
  operation.mutable_error()->set_code(15);
  operation.mutable_error()->set_message("a chunk is corrupt");
  const absl::Status status = client::OperationStatus(operation);
  CHECK(status.code() == absl::StatusCode::kDataLoss);
  CHECK_THAT(std::string(status.message()), Catch::Contains("a chunk is corrupt"));
}

TEST_CASE("Client: a series calls back for each message until the callback fails", "[client]") {
  FakeServer server;
  v1::PredictSeriesResponse first, second, third;
  first.mutable_prediction()->set_at_seconds(0.4);
  second.mutable_prediction()->set_at_seconds(0.5);
  third.mutable_prediction()->set_at_seconds(0.6);
  server.Answer("PredictSeries", first, second, third);
  const Client client = ConnectTo(server.address());
  std::vector<double> moments;
  const auto keep = [&](const v1::PredictSeriesResponse& response) {
    moments.push_back(response.prediction().at_seconds());
    return moments.size() == 5 ? absl::ResourceExhaustedError("enough") : absl::OkStatus();
  };
  CHECK(client.PredictSeries({}, keep).ok());
  CHECK(moments == std::vector<double>{0.4, 0.5, 0.6});
  const absl::Status stopped = client.PredictSeries({}, keep);
  CHECK(stopped.code() == absl::StatusCode::kResourceExhausted);
  CHECK(moments.size() == 5);
}

TEST_CASE("Client: reads maps and motion until the callback fails", "[client]") {
  FakeServer server;
  v1::ReadStateMapResponse header, nodes;
  header.mutable_header()->set_node_count(2);
  nodes.mutable_nodes()->add_node_ids(1);
  server.Answer("ReadStateMap", header, nodes);
  v1::ReadClipMotionResponse block;
  block.set_frame_count(3);
  server.Answer("ReadClipMotion", block, block);
  v1::GetFigureResponse figure;
  figure.mutable_figure()->add_marker_names("LHip");
  server.Answer("GetFigure", figure);
  v1::GetNodePosesResponse poses;
  poses.set_layer(4);
  server.Answer("GetNodePoses", poses);

  const Client client = ConnectTo(server.address());
  std::string parts;
  v1::ReadStateMapRequest map;
  map.set_parent("databases/db/models/current");
  const absl::Status read = client.ReadStateMap(map, [&](const v1::ReadStateMapResponse& part) {
    parts += part.has_header() ? "h" : "n";
    return absl::OkStatus();
  });
  CHECK(read.ok());
  CHECK(parts == "hn");
  CHECK(server.Requests<v1::ReadStateMapRequest>("ReadStateMap").at(0).parent() == map.parent());
  int frames = 0;
  const absl::Status stopped =
      client.ReadClipMotion({}, [&](const v1::ReadClipMotionResponse& received) {
        frames += received.frame_count();
        return absl::DataLossError("enough");
      });
  CHECK(stopped == absl::DataLossError("enough"));
  CHECK(frames == 3);
  const auto seen_figure = client.GetFigure({});
  REQUIRE(seen_figure.ok());
  CHECK(seen_figure->figure().marker_names(0) == "LHip");
  const auto seen_poses = client.GetNodePoses({});
  REQUIRE(seen_poses.ok());
  CHECK(seen_poses->layer() == 4);
}

TEST_CASE("Client: receives a plan of 100 MB", "[client]") {
  FakeServer server;
  v1::PlanResponse answer;
  answer.set_outcome(v1::PLAN_OUTCOME_EXACT);
  answer.mutable_motion()->mutable_file()->mutable_data()->assign(100 << 20, 'x');
  server.Answer("Plan", answer);
  const Client client = ConnectTo(server.address());
  v1::PlanRequest request;
  request.set_database("databases/walks");
  request.mutable_goal()->set_x_m(2);
  const auto response = client.Plan(request);
  INFO(response.status().ToString());
  REQUIRE(response.ok());
  CHECK(response->outcome() == v1::PLAN_OUTCOME_EXACT);
  CHECK(response->motion().file().data().size() == 100 << 20);
  const auto seen = server.Requests<v1::PlanRequest>("Plan");
  REQUIRE(seen.size() == 1);
  CHECK(seen[0].goal().x_m() == 2);
}

TEST_CASE("Client: calls of many threads at the same time", "[client]") {
  FakeServer server;
  v1::GetDatabaseResponse answer;
  answer.mutable_database()->set_name("databases/walks");
  server.Answer("GetDatabase", answer);
  const Client client = ConnectTo(server.address());
  std::atomic<int> right = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      for (int call = 0; call < 25; ++call) {
        const auto response = client.GetDatabase({});
        if (response.ok() && response->database().name() == "databases/walks") ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(right == 200);
}

}  // namespace
}  // namespace motiondb::tests::client_test
