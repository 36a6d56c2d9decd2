// Queries of a model that names a version, a layer or a page.
#include "server/engine/query/model_query.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::model_query_test {
namespace {

using server::FindLayer;
using server::LayerRequest;
using server::StateMap;
using server::WorkOptions;

void Build(TestEngine& engine, const std::string& clip, double phase) {
  const auto ingested = engine.Ingest(
      "db", clip, {.act = Act::kWalk, .frame_count = 121, .frame_rate_hz = 60, .phase = phase});
  REQUIRE(ingested.ok());
  REQUIRE(engine.Wait(ingested->operation.id).state == storage::OperationState::kSucceeded);
}

std::string PayloadOf(const absl::Status& status, const char* url) {
  const auto payload = status.GetPayload(url);
  return payload ? std::string(*payload) : "";
}

std::string FieldOf(const absl::Status& status) { return PayloadOf(status, core::kFieldUrl); }

std::string ReasonOf(const absl::Status& status) { return PayloadOf(status, core::kReasonUrl); }

TEST_CASE("Model query: a later page reads the model of the first page or fails",
          "[server][query]") {
  TestEngine engine;
  engine.Create("db");
  Build(engine, "a", 0);
  const auto first = FindLayer(*engine, {"db"}, WorkOptions{});
  REQUIRE(first.ok());
  const server::ModelStamp listed = StampOf(*first->snapshot);
  CHECK(listed.version == 1);
  // A later page does not depend on the version in the request.
  CHECK(FindLayer(*engine, {"db", 7, 0, "", listed}, WorkOptions{}).ok());
  // A model that is not stored yet has the version of another model.
  const absl::Status other =
      FindLayer(*engine, {"db", 0, 0, "", {listed.version, 1}}, WorkOptions{}).status();
  CHECK(absl::IsAborted(other));

  Build(engine, "b", 1);
  const absl::Status replaced =
      FindLayer(*engine, {"db", 0, 0, "", listed}, WorkOptions{}).status();
  CHECK(absl::IsAborted(replaced));
  CHECK(ReasonOf(replaced) == "MODEL_REPLACED");
  const absl::Status old = FindLayer(*engine, {"db", 1}, WorkOptions{}).status();
  CHECK(absl::IsFailedPrecondition(old));
  CHECK(ReasonOf(old) == "MODEL_SUPERSEDED");
}

TEST_CASE("Model query: checks the layer, the clip, the nodes and the points", "[server][query]") {
  TestEngine engine;
  engine.Create("db");
  Build(engine, "a", 0);
  const WorkOptions terms;
  CHECK(FieldOf(FindLayer(*engine, {"db", 0, 99}, terms).status()) == "layer");
  const absl::Status unknown = FindLayer(*engine, {"db", 0, 1, "c"}, terms).status();
  CHECK(absl::IsNotFound(unknown));
  CHECK(ReasonOf(unknown) == "CLIP_NOT_FOUND");
  const auto found = FindLayer(*engine, {"db"}, terms);
  REQUIRE(found.ok());
  CHECK(found->layer == found->model().layer_count());

  const int nodes[] = {0, 1 << 20};
  CHECK(ReadNodePoses(*engine, {"db", 0, 1}, std::span(nodes, 1), terms)->poses.size() == 1);
  CHECK(FieldOf(ReadNodePoses(*engine, {"db", 0, 1}, nodes, terms).status()) == "node_ids");
  CHECK(FieldOf(ReadNodePoses(*engine, {"db", 0, 1}, {}, terms).status()) == "node_ids");

  CHECK(FieldOf(StateMap::Open(*engine, {"db"}, -1, terms).status()) == "max_points");
  const auto map = StateMap::Open(*engine, {"db"}, 5, terms);
  REQUIRE(map.ok());
  CHECK((*map)->point_count() == 5);
  CHECK((*map)->TakePoints(3).size() == 3);
  CHECK((*map)->TakePoints(3).size() == 2);
  CHECK((*map)->TakePoints(3).empty());
}

TEST_CASE("State map: the memory of a call does not grow with the database", "[server][query]") {
  TestEngine engine;
  engine.Create("db");
  std::vector<std::int64_t> reserved;
  WorkOptions terms;
  terms.reserve = [&](std::int64_t bytes) {
    reserved.push_back(bytes);
    return reserved.size() == 1 ? absl::ResourceExhaustedError("full") : absl::OkStatus();
  };
  Build(engine, "a", 0);
  CHECK(absl::IsResourceExhausted(StateMap::Open(*engine, {"db"}, 10, terms).status()));
  REQUIRE(StateMap::Open(*engine, {"db"}, 10, terms).ok());
  Build(engine, "b", 1);
  REQUIRE(StateMap::Open(*engine, {"db"}, 10, terms).ok());
  REQUIRE(StateMap::Open(*engine, {"db"}, 10, terms).ok());  // knows the axes
  REQUIRE(reserved.size() == 3);
  CHECK(std::set(reserved.begin(), reserved.end()).size() == 1);
}

}  // namespace
}  // namespace motiondb::tests::model_query_test
