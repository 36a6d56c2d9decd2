// A run that derives clips again is interrupted or overtaken by changes. A model never mixes
// versions.
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <string>
#include <thread>

#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"
#include "tests/server/engine/outdated_clips.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::reprocess_interruption_test {
namespace {

using storage::OperationKind;
using storage::OperationState;

// Returns the statement that marks clips as derived by this version.
std::string SetVersion(const std::string& more) {
  return fmt::format("UPDATE clip SET representation_version = {0}, tried_version = {0}{1}",
                     core::kRepresentationVersion, more);
}

TEST_CASE("Reprocess: a new server completes an interrupted run", "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  RunSql(engine, SetVersion("") +
                     " WHERE id <> 'short'; "
                     "UPDATE operation SET state = 'running' "
                     "WHERE sequence = (SELECT max(sequence) FROM operation)");
  engine.Start();
  CHECK_THAT(AwaitOperations(engine).stage, Catch::Contains("clips derived again: 1,"));
  CHECK(engine->store().ReadClipStates("db", "short")->glitches.empty());
  CHECK(ModelIsUpToDate(engine));
  CHECK(ModelHasStoredStates(engine));
}

TEST_CASE("Reprocess: a forced run resumes with the clips that were not yet tried",
          "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  RunSql(engine,
         SetVersion(", tried_time_us = 1000") +
             "; "
             "UPDATE clip SET tried_time_us = 3000 WHERE id = 'short'; "
             "UPDATE operation SET kind = 'reprocess', state = 'running', create_time_us = 2000 "
             "WHERE sequence = (SELECT max(sequence) FROM operation)");
  engine.Start();
  const auto operation = AwaitOperations(engine);
  CHECK(operation.kind == OperationKind::kReprocess);
  CHECK_THAT(operation.stage, Catch::Contains("clips derived again: 2,"));
  CHECK(StoredClip(engine, "short").tried_time_us == 3000);
  CHECK(StoredClip(engine, "clean").tried_time_us > 3000);
}

TEST_CASE("Reprocess: a cancelled run keeps the former model, and the next start resumes",
          "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const int version = engine.ModelVersion("db");
  const std::string operation = (*engine->FindDatabase("db"))->lifecycle().operation();
  REQUIRE(engine->CancelOperation(operation)->is_first);
  engine.derive_gate().Open();
  CHECK(engine.Wait(operation).state == OperationState::kCancelled);
  CHECK(engine.ModelVersion("db") == version);
  CHECK(ModelClipIds(engine) == "clean long short ");
  engine.Stop();
  engine.Start();
  CHECK(AwaitOperations(engine).state == OperationState::kSucceeded);
  CHECK(ModelIsUpToDate(engine));
  CHECK(ModelHasStoredStates(engine));
}

TEST_CASE("Reprocess: a full disk interrupts the run, which resumes later", "[server][reprocess]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_retry_delay = std::chrono::milliseconds(50);
  TestEngine engine(options);
  FillWithOutdated(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const std::string operation = (*engine->FindDatabase("db"))->lifecycle().operation();
  engine.disk().Set(SimulatedDisk::Lacks::kRoom);
  engine.derive_gate().Open();
  engine.Wait(operation);
  CHECK(ModelClipIds(engine) == "clean long short ");
  engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  for (int i = 0; i < 6000 && !ModelIsUpToDate(engine); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(ModelIsUpToDate(engine));
}

TEST_CASE("Reprocess: a clip or database deleted meanwhile stays deleted", "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  SECTION("a clip") {
    REQUIRE(engine->DeleteClip("db", "short").ok());
    IngestBvh(engine, "short", WalkBvh(4));  // another clip with its name
    engine.derive_gate().Open();
    AwaitOperations(engine);
    CHECK(ModelClipIds(engine) == "clean long short ");
    CHECK_THAT(StoredClip(engine, "short").source_report, !Catch::Contains("glitches"));
    CHECK(ModelHasStoredStates(engine));
    CHECK(ModelIsUpToDate(engine));
    CHECK((*engine->FindDatabase("db"))->stored().clip_count == 3);
  }
  SECTION("the database") {
    auto deletion = std::async(std::launch::async, [&] { return engine->DeleteDatabase("db"); });
    engine.derive_gate().Open();
    REQUIRE(deletion.get().ok());
    engine.Create("db");
    CHECK(engine->store().ListClips("db", {})->empty());
    engine.Wait(IngestBvh(engine, "other", WalkBvh(5)));
    CHECK(ModelClipIds(engine) == "other ");
  }
}

TEST_CASE("Reprocess: a model never mixes representation versions", "[server][reprocess]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::seconds(0);
  TestEngine engine(options);
  FillWithOutdated(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const int version = engine.ModelVersion("db");
  const std::string added = IngestBvh(engine, "added", WalkBvh(3));
  const auto live = *engine->FindDatabase("db");
  const auto before = live->lifecycle().snapshot();
  // Extensions have their own thread: a scheduled one runs within some rounds.
  const auto extend = [&] {
    REQUIRE(live->WithSharedUse(server::DeletionPolicy::kRefuse,
                                [&] {
                                  live->lifecycle().RequestUpdate();
                                  return absl::OkStatus();
                                })
                .ok());
    for (int round = 0; round < 100; ++round) {
      std::promise<void> ran;
      engine->workers().Post(server::Pool::kExtensions, [&ran] { ran.set_value(); });
      ran.get_future().wait();
    }
    return ModelClipIds(engine);
  };
  SECTION("before the first clip is stored") {
    CHECK(extend() == "clean long short ");
    CHECK(engine.ModelVersion("db") == version);  // and it answers
  }
  SECTION("after the clips are stored, before the model is") {
    engine.model_gate().Close();
    engine.derive_gate().Open();
    engine.model_gate().AwaitArrival();
    CHECK(StoredClip(engine, "short").representation_version == core::kRepresentationVersion);
    // As after a crash: the former model can be read unchanged.
    const auto former = engine->store().ReadModel("db", core::RunSerially);
    REQUIRE(former.ok());
    CHECK(former->states() == before->model.states());
    CHECK(former->HasGlitch(60 + 60 + 20, 60 + 60 + 22));
    // The new model already answers, with states of the current version only.
    const auto served = live->lifecycle().snapshot();
    CHECK_FALSE(served->is_stored());
    CHECK(ModelClipIds(engine) == "added clean long short ");
    CHECK(engine.ModelVersion("db") == version);
    engine.model_gate().Open();
  }
  engine.derive_gate().Open();
  CHECK(engine.Wait(added).state == OperationState::kSucceeded);
  AwaitOperations(engine);
  CHECK(ModelClipIds(engine) == "added clean long short ");
  CHECK(ModelHasStoredStates(engine));
  CHECK(ModelIsUpToDate(engine));
}

}  // namespace
}  // namespace motiondb::tests::reprocess_interruption_test
