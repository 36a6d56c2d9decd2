// An ingest stores a complete record; a bad file stores nothing.
#include "server/engine/ingest.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <sstream>
#include <thread>
#include <tuple>
#include <vector>

#include "server/engine/snapshot.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::ingest_test {
namespace {

storage::NewClip File(const std::string& name, std::string bytes) {
  storage::NewClip clip;
  clip.record.file_name = name;
  clip.file_bytes = std::move(bytes);
  return clip;
}

std::string Walk(double phase = 0) {
  return WriteBvh({.act = Act::kWalk, .frame_count = 61, .frame_rate_hz = 30, .phase = phase});
}

TEST_CASE("Ingest: the record describes the file", "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  storage::NewClip walk = File("My walk.bvh", Walk());
  walk.record.subject = "me";
  const auto ingested = engine->Ingest(live, {walk}, {});
  INFO(ingested.status().ToString());
  REQUIRE(ingested.ok());
  const storage::ClipRecord& clip = ingested->clip;
  CHECK(clip.id == "My_walk");
  CHECK(clip.label == "unlabelled");
  CHECK(clip.subject == "me");
  CHECK(clip.frame_count == 121);  // two seconds at 60 Hz
  CHECK(clip.duration_seconds == Approx(121 / 60.0));
  CHECK(clip.source_frame_rate_hz == Approx(30));
  CHECK(clip.leg_length_m == Approx(0.82).margin(0.05));
  CHECK(!clip.skeleton_id.empty());
  CHECK(!clip.source_report.empty());
  CHECK(engine->store().ReadClipSource("db", clip.id)->file_bytes == walk.file_bytes);
  CHECK((*live->scheme())->set.marker_count() == 10);
  CHECK(live->stored().frame_count == 121);
}

// A walk whose hips are displaced in `count` frames from frame `first` (from 0).
std::string WalkWithGlitch(int first, int count) {
  std::istringstream lines(Walk());
  std::string text;
  std::string line;
  for (int frame = -1; std::getline(lines, line);) {
    if (frame >= first && frame < first + count) line = "9000" + line.substr(line.find(' '));
    if (frame >= 0 || line.starts_with("Frame Time")) ++frame;
    text += line + "\n";
  }
  return text;
}

TEST_CASE("Ingest: glitches follow the database's setting, and the report names them",
          "[server][ingest]") {
  using core::GlitchPolicy;
  TestEngine engine;
  const auto ingest = [&](const char* id, GlitchPolicy policy, int count) {
    return engine->Ingest(engine.Create(id, policy), {File("walk.bvh", WalkWithGlitch(20, count))},
                          {});
  };
  const auto repaired = ingest("repair", GlitchPolicy::kRepair, 3);
  INFO(repaired.status().ToString());
  REQUIRE(repaired.ok());
  CHECK(repaired->clip.frame_count == 121);
  CHECK_THAT(repaired->clip.source_report,
             Catch::Contains("glitches repaired (1): frames 21-23: all markers jump"));
  CHECK(engine->store().ReadClipStates("repair", "walk")->glitches.empty());

  for (const auto& [id, policy, count] :
       {std::tuple("long", GlitchPolicy::kRepair, 12), {"reject", GlitchPolicy::kReject, 1}}) {
    const auto refused = ingest(id, policy, count);
    CHECK(absl::IsInvalidArgument(refused.status()));
    CHECK_THAT(std::string(refused.status().message()), Catch::Contains("walk.bvh: frame") &&
                                                            Catch::Contains("21") &&
                                                            Catch::Contains("all markers jump"));
    CHECK(engine->store().ListClips(id, {})->empty());
  }

  const auto dropped = ingest("drop", GlitchPolicy::kDrop, 12);
  REQUIRE(dropped.ok());
  CHECK(dropped->clip.frame_count == 57);  // frames 33-61, at twice the rate
  CHECK_THAT(dropped->clip.source_report, Catch::Contains("dropped, frames 33-61 of 61 stored"));

  const auto kept = ingest("keep", GlitchPolicy::kKeep, 12);
  REQUIRE(kept.ok());
  CHECK(kept->clip.frame_count == 121);
  CHECK_THAT(kept->clip.source_report, Catch::Contains("glitches kept (1): frames 21-32"));
  CHECK(engine->store().ReadClipStates("keep", "walk")->glitches.size() == 1);
  // The model keeps the glitches, also after a restart.
  REQUIRE(engine.Wait(kept->operation.id).state == storage::OperationState::kSucceeded);
  engine.Stop();
  engine.Start();
  const auto snapshot = engine->CurrentModel(**engine->FindDatabase("keep"));
  REQUIRE(snapshot.ok());
  CHECK((*snapshot)->model.HasGlitch(50, 50));
  CHECK_FALSE((*snapshot)->model.HasGlitch(80, 120));
}

TEST_CASE("Ingest: ids from file names get a number, fixed ids are kept or refused",
          "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  CHECK(engine->Ingest(live, {File("walk.bvh", Walk(0))}, {})->clip.id == "walk");
  CHECK(engine->Ingest(live, {File("walk.bvh", Walk(1))}, {})->clip.id == "walk-2");
  const auto duplicate = engine->Ingest(live, {File("other.bvh", Walk(1))}, {});
  CHECK(absl::IsAlreadyExists(duplicate.status()));
  storage::NewClip fixed = File("walk.bvh", Walk(2));
  fixed.id_is_fixed = true;
  fixed.record.id = "walk";
  CHECK(absl::IsAlreadyExists(engine->Ingest(live, {fixed}, {}).status()));
  fixed.record.id = "mine";
  CHECK(engine->Ingest(live, {fixed}, {})->clip.id == "mine");
}

TEST_CASE("Ingest: a bad file changes nothing", "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  const std::string good = Walk();
  std::string stopped_time = good;
  stopped_time.replace(stopped_time.find("Frame Time: ") + 12, 11, "0.000000000");
  const std::string one_frame = WriteBvh({.frame_count = 1});
  // 61 frames in a century.
  std::string slow = good;
  slow.replace(slow.find("Frame Time: ") + 12, 11, "50000000.00");
  for (const std::string& bytes : {std::string("not motion"), good.substr(0, good.size() / 2),
                                   stopped_time, one_frame, slow}) {
    const auto ingested = engine->Ingest(live, {File("bad.bvh", bytes)}, {});
    INFO(ingested.status().ToString());
    CHECK(absl::IsInvalidArgument(ingested.status()));
    CHECK(std::string(ingested.status().message()).find("bad.bvh") != std::string::npos);
  }
  CHECK(engine->store().ListClips("db", {})->empty());
  CHECK(engine->operations().List("db", "", 10)->empty());
  CHECK(*live->scheme() == nullptr);
  CHECK(live->stored().clip_count == 0);
}

TEST_CASE("Ingest: nothing is stored for a cancelled call", "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  const auto ingested =
      engine->Ingest(live, {File("walk.bvh", Walk())}, {.cancelled = [] { return true; }});
  CHECK(absl::IsCancelled(ingested.status()));
  CHECK(engine->store().ListClips("db", {})->empty());
}

TEST_CASE("Ingest: the first clip of a `source` database sets the markers, also in a race",
          "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  std::vector<std::thread> threads;
  std::atomic<int> stored{0};
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back(
        [&, i] { stored += engine->Ingest(live, {File("walk.bvh", Walk(i))}, {}).ok() ? 1 : 0; });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(stored == 6);
  engine.Stop();
  engine.Start();
  CHECK((*(*engine->FindDatabase("db"))->scheme())->set.marker_count() == 10);
}

// The disk is full between the change of the clip and its operation.
TEST_CASE("Ingest: a change succeeds and is built although its operation cannot be stored",
          "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  engine.disk().Set(SimulatedDisk::Lacks::kRoomForOperations);
  const auto ingested = engine->Ingest(live, {File("walk.bvh", Walk())}, {});
  INFO(ingested.status().ToString());
  REQUIRE(ingested.ok());
  CHECK(engine->store().GetClip("db", "walk").ok());
  CHECK(engine->operations().Get(ingested->operation.id).ok());
  CHECK(engine.Wait(ingested->operation.id).model_version == 1);
  CHECK(engine.ModelVersion("db") == 1);

  const auto deleted = engine->DeleteClip("db", "walk");
  INFO(deleted.status().ToString());
  REQUIRE(deleted.ok());
  CHECK(absl::IsNotFound(engine->store().GetClip("db", "walk").status()));
  CHECK(engine.Wait(deleted->id).state == storage::OperationState::kSucceeded);
  CHECK(live->lifecycle().snapshot() == nullptr);
  CHECK(engine->operations().Get(deleted->id)->done());
}

TEST_CASE("Ingest: a deleted database refuses ingests", "[server][ingest]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  REQUIRE(engine->DeleteDatabase("db").ok());
  CHECK(absl::IsNotFound(engine->Ingest(live, {File("walk.bvh", Walk())}, {}).status()));
  CHECK(absl::IsNotFound(engine->BeginIngest(live).status()));
}

}  // namespace
}  // namespace motiondb::tests::ingest_test
