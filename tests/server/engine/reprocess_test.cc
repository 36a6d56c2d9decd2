// Clips of an older representation are derived again from their files. A model never mixes
// versions.
#include "server/engine/reprocess.h"

#include <catch2/catch.hpp>
#include <future>
#include <map>
#include <sstream>
#include <string>
#include <thread>

#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/corrupt_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::reprocess_test {
namespace {

using storage::ClipRecord;
using storage::OperationKind;
using storage::OperationState;

// A walk whose hips are displaced in some frames from the 20th on.
std::string Walk(double phase, int glitch_frames = 0) {
  std::istringstream lines(WriteBvh({.act = Act::kWalk, .frame_count = 60, .phase = phase}));
  std::string text;
  std::string line;
  for (int frame = -1; std::getline(lines, line);) {
    if (frame >= 20 && frame < 20 + glitch_frames) line = "9000" + line.substr(line.find(' '));
    if (frame >= 0 || line.starts_with("Frame Time")) ++frame;
    text += line + "\n";
  }
  return text;
}

std::string Ingest(TestEngine& engine, const std::string& name, const std::string& bvh) {
  storage::NewClip clip;
  clip.record.file_name = name + ".bvh";
  clip.record.label = name;
  clip.file_bytes = bvh;
  const auto live = *engine->FindDatabase("db");
  const auto in_flight = engine->BeginIngest(live);
  const auto ingested = engine->Ingest(live, std::move(clip), {});
  INFO(ingested.status().ToString());
  REQUIRE(ingested.ok());
  return ingested->operation.id;
}

std::string Sql(const TestEngine& engine, const std::string& script) {
  return RunSql(engine.store_path(), script);
}

// The store of a server without glitch detection: clips clean (no glitch), short (repairable) and
// long (not repairable), with a model.
void Fill(TestEngine& engine) {
  engine.Create("db", core::GlitchPolicy::kKeep);
  Ingest(engine, "clean", Walk(0));
  Ingest(engine, "long", Walk(1, 20));
  engine.Wait(Ingest(engine, "short", Walk(2, 3)));
  engine.Stop();
  Sql(engine,
      "UPDATE database SET glitches = 'repair'; "
      "UPDATE clip SET representation_version = 1, tried_version = 1, tried_time_us = 0");
}

// Waits for all operations. Returns the newest.
storage::OperationRecord Settle(TestEngine& engine) {
  const auto operations = engine->operations().List("db", "", 100);
  REQUIRE(operations.ok());
  for (const auto& operation : *operations) engine.Wait(operation.id);
  return *engine->operations().Get(operations->front().id);
}

std::size_t OperationCount(TestEngine& engine) {
  return engine->operations().List("db", "", 100)->size();
}

ClipRecord Clip(TestEngine& engine, const std::string& id) {
  const auto clip = engine->store().GetClip("db", id);
  INFO(clip.status().ToString());
  REQUIRE(clip.ok());
  return *clip;
}

std::string ClipsOfModel(TestEngine& engine) {
  const auto snapshot = (*engine->FindDatabase("db"))->lifecycle().snapshot();
  if (snapshot == nullptr) return "none";
  std::string ids;
  for (const auto& clip : snapshot->model.clips()) ids += clip.id + " ";
  return ids;
}

// Returns whether the current model has the stored states of each of its clips.
bool IsOfStoredStates(TestEngine& engine) {
  const auto snapshot = (*engine->FindDatabase("db"))->lifecycle().snapshot();
  const core::Model& model = snapshot->model;
  for (const core::ModelClip& clip : model.clips()) {
    auto stored = engine->store().ReadClipStates("db", clip.id);
    if (!stored.ok() || stored->frame_count() != clip.frame_count) return false;
    const core::FrameMatrix scaled =
        stored->states.array().rowwise() / model.scale().divisor.array();
    const auto known = model.states().middleRows(clip.first_frame, clip.frame_count);
    if (!scaled.isApprox(core::FrameMatrix(known), 1e-5F)) return false;
  }
  return true;
}

bool IsUpToDate(TestEngine& engine) { return engine->store().FindModelStaleness("db")->empty(); }

}  // namespace

TEST_CASE("Reprocess: runs automatically after an upgrade", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  engine.Start();
  const auto operation = Settle(engine);
  CHECK(operation.kind == OperationKind::kRebuild);
  CHECK(operation.state == OperationState::kSucceeded);
  CHECK_THAT(operation.stage, Catch::Contains("clips derived again: 3, changed: 1, failed: 0"));
  for (const char* id : {"clean", "short", "long"}) {
    CHECK(Clip(engine, id).representation_version == core::kRepresentationVersion);
    CHECK(Clip(engine, id).derive_error.empty());
  }
  CHECK_THAT(Clip(engine, "short").source_report, Catch::Contains("glitches repaired (1)"));
  CHECK(engine->store().ReadClipStates("db", "short")->glitches.empty());
  // Too long to be repaired, but kept because it was acknowledged.
  CHECK_THAT(Clip(engine, "long").source_report,
             Catch::Contains("glitches kept (1)") && Catch::Contains("kept because"));
  CHECK(engine->store().ReadClipStates("db", "long")->glitches.size() == 1);
  CHECK(ClipsOfModel(engine) == "clean long short ");
  CHECK(IsOfStoredStates(engine));
  CHECK(IsUpToDate(engine));
  // Data that only the former model needed is deleted.
  engine.Stop();
  CHECK(Sql(engine, "SELECT count(*) FROM clip") == "3");
  // A restart does nothing.
  engine.Start();
  const auto operations = OperationCount(engine);
  CHECK(engine.ModelVersion("db") == operation.model_version);
  engine.Stop();
  engine.Start();
  CHECK(OperationCount(engine) == operations);
}

TEST_CASE("Reprocess: unchanged clips need no new model", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, "UPDATE database SET glitches = 'keep'");
  const int version = std::stoi(Sql(engine, "SELECT version FROM model WHERE current = 1"));
  engine.Start();
  CHECK(Settle(engine).model_version == version);
  CHECK(engine.ModelVersion("db") == version);
  CHECK(IsUpToDate(engine));
}

TEST_CASE("Reprocess: a new server completes an interrupted run", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine,
      "UPDATE clip SET representation_version = 2, tried_version = 2 WHERE id <> 'short'; "
      "UPDATE operation SET state = 'running' "
      "WHERE sequence = (SELECT max(sequence) FROM operation)");
  engine.Start();
  CHECK_THAT(Settle(engine).stage, Catch::Contains("clips derived again: 1,"));
  CHECK(engine->store().ReadClipStates("db", "short")->glitches.empty());
  CHECK(IsUpToDate(engine));
  CHECK(IsOfStoredStates(engine));
}

TEST_CASE("Reprocess: a forced run resumes with the clips that were not yet tried",
          "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine,
      "UPDATE clip SET representation_version = 2, tried_version = 2, tried_time_us = 1000; "
      "UPDATE clip SET tried_time_us = 3000 WHERE id = 'short'; "
      "UPDATE operation SET kind = 'reprocess', state = 'running', create_time_us = 2000 "
      "WHERE sequence = (SELECT max(sequence) FROM operation)");
  engine.Start();
  const auto operation = Settle(engine);
  CHECK(operation.kind == OperationKind::kReprocess);
  CHECK_THAT(operation.stage, Catch::Contains("clips derived again: 2,"));
  CHECK(Clip(engine, "short").tried_time_us == 3000);
  CHECK(Clip(engine, "clean").tried_time_us > 3000);
}

TEST_CASE("Reprocess: a forced run derives all clips and restores corrupt states",
          "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  engine.Start();
  Settle(engine);
  engine.Stop();
  Sql(engine, ChangeByte("clip_chunk", 100, ChunksOf("short", 3)));
  engine.Start();
  Settle(engine);
  REQUIRE(ClipsOfModel(engine) == "clean long ");
  engine.derive_gate().Close();
  const auto requested = engine->ReprocessDatabase("db");
  REQUIRE(requested.ok());
  CHECK(requested->kind == OperationKind::kReprocess);
  engine.derive_gate().AwaitArrival();
  // A request during the run gets a new operation, which later requests join.
  const auto next = engine->ReprocessDatabase("db");
  REQUIRE(next.ok());
  CHECK(next->id != requested->id);
  CHECK(engine->ReprocessDatabase("db")->id == next->id);
  engine.derive_gate().Open();
  CHECK_THAT(engine.Wait(next->id).stage, Catch::Contains("clips derived again: 3, changed: 0"));
  const auto done = engine.Wait(requested->id);
  CHECK(done.state == OperationState::kSucceeded);
  CHECK_THAT(done.stage, Catch::Contains("clips derived again: 3, changed: 1"));
  CHECK(ClipsOfModel(engine) == "clean long short ");
  CHECK(IsOfStoredStates(engine));
  CHECK(absl::IsNotFound(engine->ReprocessDatabase("none").status()));
}

TEST_CASE("Reprocess: a model never mixes representation versions", "[server][reprocess]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::seconds(0);
  TestEngine engine(options);
  Fill(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const int version = engine.ModelVersion("db");
  const std::string added = Ingest(engine, "added", Walk(3));
  const auto live = *engine->FindDatabase("db");
  const auto before = live->lifecycle().snapshot();
  // Extensions have their own thread: a scheduled one runs within some rounds.
  const auto extend = [&] {
    REQUIRE(live->WithSharedUse(server::DeletionPolicy::kRefuse,
                                [&] {
                                  live->lifecycle().RequestExtension();
                                  return absl::OkStatus();
                                })
                .ok());
    for (int round = 0; round < 100; ++round) {
      std::promise<void> ran;
      engine->workers().Post(server::Pool::kExtensions, [&ran] { ran.set_value(); });
      ran.get_future().wait();
    }
    return ClipsOfModel(engine);
  };
  SECTION("before the first clip is stored") {
    CHECK(extend() == "clean long short ");
    CHECK(engine.ModelVersion("db") == version);  // and it answers
  }
  SECTION("after the clips are stored, before the model is") {
    engine.model_gate().Close();
    engine.derive_gate().Open();
    engine.model_gate().AwaitArrival();
    CHECK(Clip(engine, "short").representation_version == core::kRepresentationVersion);
    // As after a crash: the former model can be read unchanged.
    const auto former = engine->store().ReadModel("db", core::RunSerially);
    REQUIRE(former.ok());
    CHECK(former->states() == before->model.states());
    CHECK(former->HasGlitch(60 + 60 + 20, 60 + 60 + 22));
    // The new model already answers, with states of the current version only.
    const auto served = live->lifecycle().snapshot();
    CHECK_FALSE(served->is_stored());
    CHECK(ClipsOfModel(engine) == "added clean long short ");
    CHECK(engine.ModelVersion("db") == version);
    engine.model_gate().Open();
  }
  engine.derive_gate().Open();
  CHECK(engine.Wait(added).state == OperationState::kSucceeded);
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "added clean long short ");
  CHECK(IsOfStoredStates(engine));
  CHECK(IsUpToDate(engine));
}

TEST_CASE("Reprocess: a cancelled run keeps the former model, and the next start resumes",
          "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const int version = engine.ModelVersion("db");
  const std::string operation = (*engine->FindDatabase("db"))->lifecycle().operation();
  REQUIRE(engine->CancelOperation(operation)->is_first);
  engine.derive_gate().Open();
  CHECK(engine.Wait(operation).state == OperationState::kCancelled);
  CHECK(engine.ModelVersion("db") == version);
  CHECK(ClipsOfModel(engine) == "clean long short ");
  engine.Stop();
  engine.Start();
  CHECK(Settle(engine).state == OperationState::kSucceeded);
  CHECK(IsUpToDate(engine));
  CHECK(IsOfStoredStates(engine));
}

TEST_CASE("Reprocess: a clip or database deleted meanwhile stays deleted", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  SECTION("a clip") {
    REQUIRE(engine->DeleteClip("db", "short").ok());
    Ingest(engine, "short", Walk(4));  // another clip with its name
    engine.derive_gate().Open();
    Settle(engine);
    CHECK(ClipsOfModel(engine) == "clean long short ");
    CHECK_THAT(Clip(engine, "short").source_report, !Catch::Contains("glitches"));
    CHECK(IsOfStoredStates(engine));
    CHECK(IsUpToDate(engine));
    CHECK((*engine->FindDatabase("db"))->stored().clip_count == 3);
  }
  SECTION("the database") {
    auto deletion = std::async(std::launch::async, [&] { return engine->DeleteDatabase("db"); });
    engine.derive_gate().Open();
    REQUIRE(deletion.get().ok());
    engine.Create("db");
    CHECK(engine->store().ListClips("db", {})->empty());
    engine.Wait(Ingest(engine, "other", Walk(5)));
    CHECK(ClipsOfModel(engine) == "other ");
  }
}

TEST_CASE("Reprocess: a clip with a corrupt file is kept, reported and in no new model",
          "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, ChangeByte("clip_chunk", 100, ChunksOf("short", 1)));
  engine.Start();
  CHECK_THAT(Settle(engine).stage, Catch::Contains("failed: 1"));
  const ClipRecord clip = Clip(engine, "short");
  CHECK(clip.representation_version == 1);
  CHECK(clip.tried_version == core::kRepresentationVersion);
  CHECK_THAT(clip.derive_error, Catch::Contains("chunk 0"));
  CHECK(engine->store().ReadClipStates("db", "short").ok());
  const auto underived = [&] { return (*engine->FindDatabase("db"))->underived(); };
  CHECK(underived() == std::map<std::string, std::string>{{"short", clip.derive_error}});
  CHECK(ClipsOfModel(engine) == "clean long ");
  CHECK(IsUpToDate(engine));
  const int version = engine.ModelVersion("db");
  const auto operations = OperationCount(engine);
  engine.Stop();

  // It does not cause another build, and is tried again on request.
  engine.Start();
  CHECK(engine.ModelVersion("db") == version);
  CHECK(OperationCount(engine) == operations);
  CHECK(underived().size() == 1);
  const auto again = engine.Wait(engine->ReprocessDatabase("db")->id);
  CHECK_THAT(again.stage, Catch::Contains("clips derived again: 3"));
  CHECK(Clip(engine, "short").tried_time_us > clip.tried_time_us);
  CHECK(engine.ModelVersion("db") == version);
  engine.Wait(engine->DeleteClip("db", "short")->id);
  CHECK(underived().empty());
}

TEST_CASE("Reprocess: the former model stays if no clip can be derived", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  for (const char* id : {"clean", "short", "long"}) {
    Sql(engine, ChangeByte("clip_chunk", 100, ChunksOf(id, 1)));
  }
  engine.Start();
  const auto operation = Settle(engine);
  CHECK(operation.state == OperationState::kFailed);
  CHECK_THAT(operation.error_message, Catch::Contains("no clip could be derived again"));
  CHECK(ClipsOfModel(engine) == "clean long short ");
  engine.Stop();
  engine.Start();
  CHECK(ClipsOfModel(engine) == "clean long short ");
}

TEST_CASE("Reprocess: uses the parameters of the ingest", "[server][reprocess]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  storage::NewClip clip;
  clip.record.file_name = "walk.bvh";
  clip.file_bytes = Walk(0);
  clip.record.given = {.metres_per_unit = 0.02, .up_axis = core::UpAxis::kY, .frame_rate_hz = 30};
  clip.record.given_leg_length_m = 1.9;
  const auto ingested = engine->Ingest(live, std::move(clip), {});
  REQUIRE(ingested.ok());
  engine.Wait(ingested->operation.id);
  const ClipRecord before = Clip(engine, "walk");
  CHECK(before.given.metres_per_unit == 0.02);
  CHECK(before.given.up_axis == core::UpAxis::kY);
  CHECK(before.given.frame_rate_hz == 30);
  CHECK(before.given_leg_length_m == 1.9);
  const auto done = engine.Wait(engine->ReprocessDatabase("db")->id);
  CHECK_THAT(done.stage, Catch::Contains("clips derived again: 1, changed: 0"));
  CHECK(Clip(engine, "walk").source_report == before.source_report);
}

TEST_CASE("Reprocess: a full disk interrupts the run, which resumes later", "[server][reprocess]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_retry_delay = std::chrono::milliseconds(50);
  TestEngine engine(options);
  Fill(engine);
  engine.derive_gate().Close();
  engine.Start();
  engine.derive_gate().AwaitArrival();
  const std::string operation = (*engine->FindDatabase("db"))->lifecycle().operation();
  engine.disk().Set(SimulatedDisk::Lacks::kRoom);
  engine.derive_gate().Open();
  engine.Wait(operation);
  CHECK(ClipsOfModel(engine) == "clean long short ");
  engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  for (int i = 0; i < 6000 && !IsUpToDate(engine); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(IsUpToDate(engine));
}

TEST_CASE("Reprocess: a read-only store is served unchanged", "[server][reprocess]") {
  TestEngine engine;
  Fill(engine);
  auto store = storage::SqliteMotionStore::Open(engine.store_path(), {.read_only = true});
  REQUIRE(store.ok());
  const auto reader = server::Engine::Open(*std::move(store), TestEngine::QuickOptions());
  REQUIRE(reader.ok());
  const auto snapshot = (*(*reader)->FindDatabase("db"))->lifecycle().snapshot();
  REQUIRE(snapshot != nullptr);
  CHECK(snapshot->model.clips().size() == 3);
  CHECK((*(*reader)->FindDatabase("db"))->lifecycle().operation().empty());
  CHECK(absl::IsFailedPrecondition((*reader)->ReprocessDatabase("db").status()));
}

}  // namespace motiondb::tests::reprocess_test
