// When models are rebuilt, and which model answers meanwhile.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "server/engine/query/model_query.h"
#include "server/engine/snapshot.h"
#include "tests/support/captured_log.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::model_lifecycle_test {
namespace {

using storage::OperationState;

TEST_CASE("Lifecycle: a burst of ingests costs one rebuild", "[server][lifecycle]") {
  TestEngine engine;
  engine.Create("db");
  std::vector<std::thread> threads;
  std::vector<absl::StatusOr<server::Ingested>> ingested(8);
  for (std::size_t i = 0; i < ingested.size(); ++i) {
    threads.emplace_back(
        [&, i] { ingested[i] = engine.Ingest("db", "walk", Walk(0.3 * static_cast<double>(i))); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& each : ingested) {
    REQUIRE(each.ok());
    CHECK(each->operation.id == ingested[0]->operation.id);
  }
  const auto operation = engine.Wait(ingested[0]->operation.id);
  CHECK(operation.state == OperationState::kSucceeded);
  CHECK(operation.model_version == 1);
  CHECK(engine.ModelVersion("db") == 1);
  CHECK(engine->operations().List("db", "", 10)->size() == 1);
  CHECK((*engine->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 8);
}

TEST_CASE("Lifecycle: warns if a tree of many frames is a single node", "[server][lifecycle]") {
  TestEngine engine;  // first, because it disables the log
  const CapturedLog log(spdlog::level::warn);
  engine.Create("walks");
  engine.Create("statues");
  const StickFigure statue{.act = Act::kSquat, .frame_count = 200, .tempo = 0};
  for (const auto& ingested :
       {engine.Ingest("walks", "walk", Walk(0)), engine.Ingest("statues", "statue", statue)}) {
    REQUIRE(ingested.ok());
    REQUIRE(engine.Wait(ingested->operation.id).state == OperationState::kSucceeded);
  }
  engine.Stop();
  CAPTURE(log.text());
  CHECK(log.text().find("database 'statues': the tree of model 1 is a single node of 200 frames") !=
        std::string::npos);
  CHECK(log.text().find("walks") == std::string::npos);
}

TEST_CASE("Lifecycle: waits for an ingest in flight, up to rebuild_delay_limit",
          "[server][lifecycle]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_delay_limit = std::chrono::milliseconds(400);
  TestEngine engine(options);
  const auto live = engine.Create("db");
  const auto slow = *engine->BeginIngest(live);
  const auto requested = std::chrono::steady_clock::now();
  const auto ingested = engine.Ingest("db", "walk", Walk(0));
  REQUIRE(ingested.ok());
  CHECK(engine.Wait(ingested->operation.id).state == OperationState::kSucceeded);
  CHECK(std::chrono::steady_clock::now() - requested >= std::chrono::milliseconds(400));
}

TEST_CASE("Lifecycle: requests during a build get the next build", "[server][lifecycle]") {
  TestEngine engine;
  engine.Create("db");
  engine.gate().Close();
  const auto first = engine.Ingest("db", "a", Walk(0));
  engine.gate().AwaitArrival();
  CHECK(engine->operations().Get(first->operation.id)->state == OperationState::kRunning);
  const auto second = engine.Ingest("db", "b", Walk(1));
  const auto third = engine.Ingest("db", "c", Walk(2));
  CHECK(second->operation.id != first->operation.id);
  CHECK(third->operation.id == second->operation.id);
  CHECK(second->operation.state == OperationState::kPending);
  engine.gate().Open();
  CHECK(engine.Wait(first->operation.id).model_version == 1);
  CHECK(engine.Wait(third->operation.id).model_version == 2);
  CHECK((*engine->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 3);
}

TEST_CASE("Lifecycle: the previous model answers until the new one is complete",
          "[server][lifecycle]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  const auto before = live->lifecycle().snapshot();
  REQUIRE(before != nullptr);
  engine.gate().Close();
  const auto second = engine.Ingest("db", "b", Walk(1));
  engine.gate().AwaitArrival();
  CHECK(live->lifecycle().snapshot() == before);
  CHECK((*engine->CurrentModel(*live))->record.version == 1);
  engine.gate().Open();
  engine.Wait(second->operation.id);
  CHECK(live->lifecycle().snapshot()->record.version == 2);
  CHECK(before->model.clips().size() == 1);  // users of the old model keep it
}

TEST_CASE("Lifecycle: a new model answers before it is stored, and marks its calibration",
          "[server][lifecycle]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  const auto served = [&] { return live->lifecycle().snapshot(); };
  const auto build = [&](const std::string& clip, double phase) {
    engine.model_gate().Close();
    const std::string operation = engine.Ingest("db", clip, Walk(phase))->operation.id;
    engine.model_gate().AwaitArrival();
    CHECK(engine->operations().Get(operation)->state == OperationState::kRunning);
    return operation;
  };
  const std::string first = build("a", 0);
  REQUIRE(served() != nullptr);
  CHECK(served()->calibration == server::Calibration::kTypical);
  CHECK(served()->record.version == 0);  // not stored yet
  CHECK(served()->record.clip_count == 1);
  CHECK(served()->model.recognition().window.weight.scale ==
        core::RecognitionCalibration().window.weight.scale);
  CHECK(engine->CurrentModel(*live).ok());
  CHECK(absl::IsNotFound(engine->store().GetModel("db", 1).status()));
  engine.model_gate().Open();
  CHECK(engine.Wait(first).model_version == 1);
  REQUIRE(engine.Ingest("db", "b", Walk(1)).ok());
  engine.Wait(engine.Ingest("db", "c", Walk(2))->operation.id);

  const auto before = served();
  CHECK(before->calibration == server::Calibration::kOwn);
  REQUIRE_FALSE(before->model.recognition().window.familiarity.empty());
  const std::string last = build("d", 3);
  CHECK(served()->calibration == server::Calibration::kPrevious);
  CHECK(served()->record.version == before->record.version);
  const auto map_version = [&] {
    const auto map = server::StateMap::Open(*engine, {.database = "db"}, 0, {});
    REQUIRE(map.ok());
    return (*map)->model_version();
  };
  CHECK(map_version() == 0);
  CHECK(served()->model.clips().size() == 4);
  CHECK(served()->record.frame_count == 240);
  CHECK(served()->model.recognition().window.familiarity ==
        before->model.recognition().window.familiarity);
  const auto answering = served();
  engine.model_gate().Open();
  CHECK(engine.Wait(last).model_version == before->record.version + 1);
  CHECK(served()->calibration == server::Calibration::kOwn);
  CHECK(served()->record.version == before->record.version + 1);
  CHECK(map_version() == before->record.version + 1);
  CHECK(served()->model.states() == answering->model.states());
  CHECK(served()->model.recognition().window.familiarity !=
        answering->model.recognition().window.familiarity);
}

TEST_CASE("Lifecycle: deleting clips rebuilds, deleting the last drops the model",
          "[server][lifecycle]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  REQUIRE(engine.Ingest("db", "a", Walk(0)).ok());
  engine.Wait(engine.Ingest("db", "b", Walk(1))->operation.id);
  REQUIRE(live->lifecycle().snapshot()->model.clips().size() == 2);
  engine.Wait(engine->DeleteClip("db", "a")->id);
  REQUIRE(live->lifecycle().snapshot()->model.clips().size() == 1);
  CHECK(live->lifecycle().snapshot()->model.clips()[0].id == "b");
  const auto last = engine.Wait(engine->DeleteClip("db", "b")->id);
  CHECK(last.state == OperationState::kSucceeded);
  CHECK(last.model_version == 0);
  CHECK(live->lifecycle().snapshot() == nullptr);
  CHECK(live->stored().clip_count == 0);
  CHECK(absl::IsFailedPrecondition(engine->CurrentModel(*live).status()));
  CHECK(absl::IsNotFound(engine->DeleteClip("db", "b").status()));
}

}  // namespace
}  // namespace motiondb::tests::model_lifecycle_test
