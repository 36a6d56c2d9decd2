#include "tests/server/engine/outdated_clips.h"

#include <catch2/catch.hpp>
#include <sstream>
#include <utility>

#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {

std::string WalkBvh(double phase, int glitch_frames) {
  std::istringstream lines(WriteBvh(Walk(phase)));
  std::string text;
  std::string line;
  for (int frame = -1; std::getline(lines, line);) {
    if (frame >= 20 && frame < 20 + glitch_frames) line = "9000" + line.substr(line.find(' '));
    if (frame >= 0 || line.starts_with("Frame Time")) ++frame;
    text += line + "\n";
  }
  return text;
}

std::string IngestBvh(TestEngine& engine, const std::string& name, const std::string& bvh) {
  storage::NewClip clip;
  clip.record.file_name = name + ".bvh";
  clip.record.label = name;
  clip.file_bytes = bvh;
  const auto live = *engine->FindDatabase("db");
  const auto in_flight = engine->BeginIngest(live);
  const auto ingested = engine->Ingest(live, {std::move(clip)}, {});
  INFO(ingested.status().ToString());
  REQUIRE(ingested.ok());
  return ingested->operation.id;
}

std::string RunSql(const TestEngine& engine, const std::string& script) {
  return RunSql(engine.store_path(), script);
}

void FillWithOutdated(TestEngine& engine) {
  engine.Create("db", core::GlitchPolicy::kKeep);
  IngestBvh(engine, "clean", WalkBvh(0));
  IngestBvh(engine, "long", WalkBvh(1, 20));
  engine.Wait(IngestBvh(engine, "short", WalkBvh(2, 3)));
  engine.Stop();
  RunSql(engine,
         "UPDATE database SET glitches = 'repair'; "
         "UPDATE clip SET representation_version = 1, tried_version = 1, tried_time_us = 0");
}

storage::OperationRecord AwaitOperations(TestEngine& engine) {
  const auto operations = engine->operations().List("db", "", 100);
  REQUIRE(operations.ok());
  for (const auto& operation : *operations) engine.Wait(operation.id);
  return *engine->operations().Get(operations->front().id);
}

std::size_t OperationCount(TestEngine& engine) {
  return engine->operations().List("db", "", 100)->size();
}

storage::ClipRecord StoredClip(TestEngine& engine, const std::string& id) {
  const auto clip = engine->store().GetClip("db", id);
  INFO(clip.status().ToString());
  REQUIRE(clip.ok());
  return *clip;
}

std::string ModelClipIds(TestEngine& engine) {
  const auto snapshot = (*engine->FindDatabase("db"))->lifecycle().snapshot();
  if (snapshot == nullptr) return "none";
  std::string ids;
  for (const auto& clip : snapshot->model.clips()) ids += clip.id + " ";
  return ids;
}

bool ModelHasStoredStates(TestEngine& engine) {
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

bool ModelIsUpToDate(TestEngine& engine) {
  return engine->store().FindModelStaleness("db")->empty();
}

}  // namespace motiondb::tests
