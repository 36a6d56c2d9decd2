// Clips of an older representation are derived again from their files.
#include "server/engine/reprocess.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <utility>

#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/server/engine/outdated_clips.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::reprocess_test {
namespace {

using storage::ClipRecord;
using storage::OperationKind;
using storage::OperationState;

TEST_CASE("Reprocess: runs automatically after an upgrade", "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  engine.Start();
  const auto operation = AwaitOperations(engine);
  CHECK(operation.kind == OperationKind::kRebuild);
  CHECK(operation.state == OperationState::kSucceeded);
  CHECK_THAT(operation.stage, Catch::Contains("clips derived again: 3, changed: 1, failed: 0"));
  for (const char* id : {"clean", "short", "long"}) {
    CHECK(StoredClip(engine, id).representation_version == core::kRepresentationVersion);
    CHECK(StoredClip(engine, id).derive_error.empty());
  }
  CHECK_THAT(StoredClip(engine, "short").source_report, Catch::Contains("glitches repaired (1)"));
  CHECK(engine->store().ReadClipStates("db", "short")->glitches.empty());
  // Too long to be repaired, but kept because it was acknowledged.
  CHECK_THAT(StoredClip(engine, "long").source_report,
             Catch::Contains("glitches kept (1)") && Catch::Contains("kept because"));
  CHECK(engine->store().ReadClipStates("db", "long")->glitches.size() == 1);
  CHECK(ModelClipIds(engine) == "clean long short ");
  CHECK(ModelHasStoredStates(engine));
  CHECK(ModelIsUpToDate(engine));
  // Data that only the former model needed is deleted.
  engine.Stop();
  CHECK(RunSql(engine, "SELECT count(*) FROM clip") == "3");
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
  FillWithOutdated(engine);
  RunSql(engine, "UPDATE database SET glitches = 'keep'");
  const int version = std::stoi(RunSql(engine, "SELECT version FROM model WHERE current = 1"));
  engine.Start();
  CHECK(AwaitOperations(engine).model_version == version);
  CHECK(engine.ModelVersion("db") == version);
  CHECK(ModelIsUpToDate(engine));
}

TEST_CASE("Start: a model without calibration for unknown motion, of an older version, is rebuilt",
          "[server][reprocess]") {
  TestEngine engine;
  engine.Create("db");
  IngestBvh(engine, "a", WalkBvh(0));
  engine.Wait(IngestBvh(engine, "b", WalkBvh(1)));
  engine.Stop();
  int version = 0;
  {
    const auto store = storage::SqliteMotionStore::Open(engine.store_path());
    REQUIRE(store.ok());
    auto model = (*store)->ReadModel("db", core::RunSerially);
    REQUIRE(model.ok());
    core::RecognitionCalibration older = model->recognition();
    older.unknown = core::UnknownCalibration::kNotFitted;
    older.window.unknown.reset();
    older.whole.unknown.reset();
    model->set_recognition(older);
    const auto put = (*store)->PutModel("db", *model);
    REQUIRE(put.ok());
    version = put->version;
  }
  engine.Start();
  AwaitOperations(engine);
  const auto live = *engine->FindDatabase("db");
  const auto current = engine->CurrentModel(*live);
  REQUIRE(current.ok());
  CHECK((*current)->record.version > version);
  CHECK((*current)->model.recognition().unknown == core::UnknownCalibration::kOneSubject);
  // The next start does not build again.
  const auto operations = OperationCount(engine);
  engine.Stop();
  engine.Start();
  CHECK(OperationCount(engine) == operations);
}

TEST_CASE("Reprocess: uses the parameters of the ingest", "[server][reprocess]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  storage::NewClip clip;
  clip.record.file_name = "walk.bvh";
  clip.file_bytes = WalkBvh(0);
  clip.record.given = {.metres_per_unit = 0.02, .up_axis = core::UpAxis::kY, .frame_rate_hz = 30};
  clip.record.given_leg_length_m = 1.9;
  const auto ingested = engine->Ingest(live, {.clip = std::move(clip), .force = true}, {});
  REQUIRE(ingested.ok());
  engine.Wait(ingested->operation.id);
  const ClipRecord before = StoredClip(engine, "walk");
  CHECK(before.given.metres_per_unit == 0.02);
  CHECK(before.given.up_axis == core::UpAxis::kY);
  CHECK(before.given.frame_rate_hz == 30);
  CHECK(before.given_leg_length_m == 1.9);
  const auto done = engine.Wait(engine->ReprocessDatabase("db")->id);
  CHECK_THAT(done.stage, Catch::Contains("clips derived again: 1, changed: 0"));
  CHECK(StoredClip(engine, "walk").source_report == before.source_report);
}

TEST_CASE("Reprocess: a forced run derives all clips and restores corrupt states",
          "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  engine.Start();
  AwaitOperations(engine);
  engine.Stop();
  RunSql(engine, ChangeByte("clip_chunk", 100, ChunksOf("short", 3)));
  engine.Start();
  AwaitOperations(engine);
  REQUIRE(ModelClipIds(engine) == "clean long ");
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
  CHECK(ModelClipIds(engine) == "clean long short ");
  CHECK(ModelHasStoredStates(engine));
  CHECK(absl::IsNotFound(engine->ReprocessDatabase("none").status()));
}

TEST_CASE("Reprocess: a clip with a corrupt file is kept, reported and in no new model",
          "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  RunSql(engine, ChangeByte("clip_chunk", 100, ChunksOf("short", 1)));
  engine.Start();
  CHECK_THAT(AwaitOperations(engine).stage, Catch::Contains("failed: 1"));
  const ClipRecord clip = StoredClip(engine, "short");
  CHECK(clip.representation_version == 1);
  CHECK(clip.tried_version == core::kRepresentationVersion);
  CHECK_THAT(clip.derive_error, Catch::Contains("chunk 0"));
  CHECK(engine->store().ReadClipStates("db", "short").ok());
  const auto underived = [&] { return (*engine->FindDatabase("db"))->underived(); };
  CHECK(underived() == std::map<std::string, std::string>{{"short", clip.derive_error}});
  CHECK(ModelClipIds(engine) == "clean long ");
  CHECK(ModelIsUpToDate(engine));
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
  CHECK(StoredClip(engine, "short").tried_time_us > clip.tried_time_us);
  CHECK(engine.ModelVersion("db") == version);
  engine.Wait(engine->DeleteClip("db", "short")->id);
  CHECK(underived().empty());
}

TEST_CASE("Reprocess: the former model stays if no clip can be derived", "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
  for (const char* id : {"clean", "short", "long"}) {
    RunSql(engine, ChangeByte("clip_chunk", 100, ChunksOf(id, 1)));
  }
  engine.Start();
  const auto operation = AwaitOperations(engine);
  CHECK(operation.state == OperationState::kFailed);
  CHECK_THAT(operation.error_message, Catch::Contains("no clip could be derived again"));
  CHECK(ModelClipIds(engine) == "clean long short ");
  engine.Stop();
  engine.Start();
  CHECK(ModelClipIds(engine) == "clean long short ");
}

TEST_CASE("Reprocess: a read-only store is served unchanged", "[server][reprocess]") {
  TestEngine engine;
  FillWithOutdated(engine);
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

}  // namespace
}  // namespace motiondb::tests::reprocess_test
