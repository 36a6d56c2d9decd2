#include <catch2/catch.hpp>
#include <map>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/model.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::model_service_test {
namespace {

using Stub = v1::ModelService::Stub;

constexpr char kCurrent[] = "databases/db/models/current";

// Builds a second model of the trained database.
void Retrain(TestServer& server) {
  const auto ingested = server.IngestFigure("db", "more", "walk", {.phase = 2});
  REQUIRE(server.Wait(ingested.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
}

TEST_CASE("ModelService: statistics of the current and of earlier models", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ModelService>();
  v1::GetModelRequest get;
  get.set_name(kCurrent);
  const v1::Model model = Ask(*stub, &Stub::GetModel, get).response.model();
  CHECK(model.name() == "databases/db/models/1");
  CHECK(model.state() == v1::MODEL_STATE_CURRENT);
  CHECK(model.dimension_count() == 60);
  CHECK(model.scaling() == v1::SCALING_KIND);
  CHECK(model.scales().size() == sizeof(float) * 60);
  REQUIRE(model.clips_size() == 3);
  CHECK(model.clips(1) == "databases/db/clips/walk");
  CHECK(model.first_frames(1) == 120);
  CHECK(model.build_seconds() > 0);

  Retrain(server);
  get.set_name("databases/db/models/1");
  const v1::Model former = Ask(*stub, &Stub::GetModel, get).response.model();
  CHECK(former.state() == v1::MODEL_STATE_SUPERSEDED);
  CHECK(former.frame_count() == 360);
  CHECK(former.clips().empty());

  v1::ListModelsRequest list;
  list.set_parent("databases/db");
  list.set_page_size(1);
  const auto newest = Ask(*stub, &Stub::ListModels, list);
  REQUIRE(newest.status.ok());
  CHECK(newest.response.models(0).version() == 2);
  list.set_page_token(newest.response.next_page_token());
  const auto oldest = Ask(*stub, &Stub::ListModels, list);
  CHECK(oldest.response.models(0).version() == 1);
  CHECK(oldest.response.next_page_token().empty());
}

TEST_CASE("ModelService, GetDatabase, Recognize: a model that is not calibrated yet",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ModelService>();
  const auto get = [&](const std::string& name) {
    v1::GetModelRequest request;
    request.set_name(name);
    const auto answer = Ask(*stub, &Stub::GetModel, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    return answer.response.model();
  };
  v1::ListNodesRequest nodes;
  nodes.set_parent(kCurrent);
  nodes.set_page_size(2);
  nodes.set_page_token(Ask(*stub, &Stub::ListNodes, nodes).response.next_page_token());
  REQUIRE_FALSE(nodes.page_token().empty());
  CHECK(get(kCurrent).calibration() == v1::CALIBRATION_ONE_SUBJECT);
  CHECK(server.Describe("db").calibration() == v1::CALIBRATION_ONE_SUBJECT);

  server.model_gate().Close();
  const auto ingested =
      server.IngestFigure("db", "more", "stroll", {.frame_count = 60, .phase = 2});
  server.model_gate().AwaitArrival();
  const auto described = server.Describe("db");
  CHECK(described.calibration() == v1::CALIBRATION_PREVIOUS);
  CHECK(described.clip_count() == 4);
  CHECK(described.model_version() == 1);
  const v1::Model current = get(kCurrent);
  CHECK(current.name() == kCurrent);
  CHECK(current.state() == v1::MODEL_STATE_CURRENT);
  CHECK(current.calibration() == v1::CALIBRATION_PREVIOUS);
  CHECK(current.clip_count() == 4);
  CHECK(current.clips_size() == 4);
  const v1::Model stored = get("databases/db/models/1");
  CHECK(stored.state() == v1::MODEL_STATE_SUPERSEDED);
  CHECK(stored.calibration() == v1::CALIBRATION_OWN);
  CHECK(stored.clip_count() == 3);
  // It has the version of the stored model, but is another model.
  CHECK(Ask(*stub, &Stub::ListNodes, nodes).status.error_code() == grpc::StatusCode::ABORTED);
  nodes.clear_page_token();
  CHECK(Ask(*stub, &Stub::ListNodes, nodes).status.ok());
  nodes.set_parent("databases/db/models/1");
  CHECK(Ask(*stub, &Stub::ListNodes, nodes).status.error_code() ==
        grpc::StatusCode::FAILED_PRECONDITION);
  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  *recognize.mutable_observation() = WalkObservation();
  const auto queries = server.NewStub<v1::QueryService>();
  const auto ask = [&] {
    const auto answer = Ask(*queries, &v1::QueryService::Stub::Recognize, recognize);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    return answer.response.calibration();
  };
  CHECK(ask() == v1::CALIBRATION_PREVIOUS);
  server.model_gate().Open();
  server.Wait(ingested.operation().name());
  CHECK(ask() == v1::CALIBRATION_ONE_SUBJECT);
  CHECK(get(kCurrent).name() == "databases/db/models/2");
  CHECK(server.Describe("db").calibration() == v1::CALIBRATION_ONE_SUBJECT);
}

TEST_CASE("ModelService: unknown databases, models and layers", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("empty");
  const auto stub = server.NewStub<v1::ModelService>();
  const auto code = [&](const std::string& name) {
    v1::GetModelRequest get;
    get.set_name(name);
    return Ask(*stub, &Stub::GetModel, get).status.error_code();
  };
  CHECK(code("databases/empty/models/current") == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(code("databases/empty/models/1") == grpc::StatusCode::NOT_FOUND);
  CHECK(code("databases/none/models/1") == grpc::StatusCode::NOT_FOUND);
  CHECK(code("databases/empty/models/x") == grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_CASE("ModelService: the nodes of each layer have every frame once", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ModelService>();
  const auto described = server.Describe("db");
  for (int layer = 1; layer <= described.layer_count(); ++layer) {
    v1::ListNodesRequest request;
    request.set_parent(kCurrent);
    request.set_layer(layer);
    request.set_page_size(7);
    int frames = 0;
    int next = 0;
    do {
      const auto page = Ask(*stub, &Stub::ListNodes, request);
      INFO(page.status.error_message());
      REQUIRE(page.status.ok());
      for (const v1::Node& node : page.response.nodes()) {
        CHECK(node.node_id() == next++);
        CHECK(node.has_parent_id() == (layer > 1));
        CHECK(node.mean().size() == 60 * 4);
        CHECK(node.variance().size() == 60 * 4);
        frames += node.frame_count();
      }
      request.set_page_token(page.response.next_page_token());
    } while (!request.page_token().empty());
    CHECK(next == described.nodes_per_layer(layer - 1));
    CHECK(frames == described.frame_count());
  }
  v1::ListNodesRequest request;
  request.set_parent(kCurrent);
  request.set_layer(99);
  const auto beyond = Ask(*stub, &Stub::ListNodes, request);
  CHECK(beyond.status.error_code() == grpc::StatusCode::OUT_OF_RANGE);
  CHECK(ViolatedFields(beyond.status) == "layer");
}

TEST_CASE("ModelService: transitions of a row sum to one, also across pages", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ModelService>();
  for (const char* clip : {"", "databases/db/clips/walk"}) {
    v1::ListTransitionsRequest request;
    request.set_parent(kCurrent);
    request.set_clip(clip);
    request.set_page_size(5);
    std::map<int, double> sums;
    int count = 0;
    std::pair<int, int> last(-1, -1);
    do {
      const auto page = Ask(*stub, &Stub::ListTransitions, request);
      INFO(page.status.error_message());
      REQUIRE(page.status.ok());
      for (const v1::Transition& transition : page.response.transitions()) {
        const std::pair edge(transition.from_node_id(), transition.to_node_id());
        CHECK(last < edge);
        last = edge;
        sums[edge.first] += transition.probability();
        count += transition.count();
      }
      request.set_page_token(page.response.next_page_token());
    } while (!request.page_token().empty());
    CHECK(count == (*clip == 0 ? 3 * 119 : 119));
    for (const auto& [from, sum] : sums) CHECK(sum == Approx(1));
  }
  v1::ListTransitionsRequest request;
  request.set_parent(kCurrent);
  request.set_clip("databases/db/clips/none");
  CHECK(Ask(*stub, &Stub::ListTransitions, request).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
  request.set_clip("databases/other/clips/walk");
  CHECK(ViolatedFields(Ask(*stub, &Stub::ListTransitions, request).status) == "clip");
}

TEST_CASE("ModelService: listing a replaced model is ABORTED", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ModelService>();
  v1::ListNodesRequest request;
  request.set_parent("databases/db/models/1");
  request.set_page_size(1);
  request.set_page_token(Ask(*stub, &Stub::ListNodes, request).response.next_page_token());
  REQUIRE(!request.page_token().empty());
  Retrain(server);
  const auto stale = Ask(*stub, &Stub::ListNodes, request);
  CHECK(stale.status.error_code() == grpc::StatusCode::ABORTED);
  CHECK(stale.status.error_message().find("first page") != std::string::npos);
  request.clear_page_token();
  CHECK(Ask(*stub, &Stub::ListNodes, request).status.error_code() ==
        grpc::StatusCode::FAILED_PRECONDITION);
  request.set_parent("databases/db/models/7");
  CHECK(Ask(*stub, &Stub::ListNodes, request).status.error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("ModelService: states are sent in blocks of at most 1 MiB", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto ingested = server.IngestFigure("db", "long", "walk", {.frame_count = 6000});
  REQUIRE(server.Wait(ingested.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
  const auto stub = server.NewStub<v1::ModelService>();
  v1::ReadStatesRequest request;
  request.set_name(kCurrent);
  grpc::ClientContext context;
  const auto reader = stub->ReadStates(&context, request);
  v1::ReadStatesResponse block;
  int frames = 0;
  int blocks = 0;
  while (reader->Read(&block)) {
    CHECK(block.ByteSizeLong() <= 1 << 20);
    CHECK(block.first_frame() == frames);
    CHECK(block.states().size() == static_cast<std::size_t>(block.frame_count()) * 60 * 4);
    CHECK(block.bottom_node_ids_size() == block.frame_count());
    frames += block.frame_count();
    ++blocks;
  }
  CHECK(reader->Finish().ok());
  CHECK(frames == 6000);
  CHECK(blocks == 2);
}

}  // namespace
}  // namespace motiondb::tests::model_service_test
