// Limits of a database.
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/model/model.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/gated_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::quota_test {
namespace {

absl::Status Ingest(TestEngine& engine, const std::string& name, double phase) {
  return engine
      .Ingest("db", name,
              {.act = Act::kWalk, .frame_count = 61, .frame_rate_hz = 60, .phase = phase})
      .status();
}

void CheckExhausted(const absl::Status& status, const std::string& setting) {
  INFO(status.ToString());
  CHECK(absl::IsResourceExhausted(status));
  CHECK(std::string(status.message()).find(setting) != std::string::npos);
}

server::EngineOptions With(const server::DatabaseQuota& quota) {
  server::EngineOptions options = TestEngine::QuickOptions();
  options.quota = quota;
  return options;
}

TEST_CASE("Quota: clips, frames and bytes of a database are limited", "[server][quota]") {
  const auto [quota, setting] = GENERATE(table<server::DatabaseQuota, std::string>({
      {{.clip_count = 2}, "--max-database-clips"},
      {{.frame_count = 122}, "--max-database-frames"},
      // The states of a clip are 10 markers x 6 numbers x 61 frames.
      {{.byte_count = 3 * 61 * 60 * 4}, "--max-database-mib"},
  }));
  TestEngine engine(With(quota));
  const auto live = engine.Create("db");
  int stored = 0;
  absl::Status status;
  while (status.ok() && stored < 3) {
    status = Ingest(engine, "walk" + std::to_string(stored), stored);
    if (status.ok()) ++stored;
  }
  CheckExhausted(status, setting);
  CHECK(stored >= 1);
  CHECK(live->stored().clip_count == stored);
  CHECK(engine->store().ListClips("db", {})->size() == static_cast<std::size_t>(stored));

  // A deleted clip makes room for another, also after a restart.
  REQUIRE(engine->DeleteClip("db", "walk0").ok());
  CHECK(Ingest(engine, "again", 7).ok());
  engine.Stop();
  engine.Start();
  CheckExhausted(Ingest(engine, "more", 8), setting);
}

TEST_CASE("Quota: a clip that is refused for another reason is not counted", "[server][quota]") {
  TestEngine engine(With({.clip_count = 2}));
  engine.Create("db");
  REQUIRE(Ingest(engine, "walk", 1).ok());
  for (int i = 0; i < 3; ++i) CHECK(absl::IsAlreadyExists(Ingest(engine, "walk", 1)));
  CHECK(Ingest(engine, "other", 2).ok());
}

TEST_CASE("Quota: the count equals the store's byte count, also after a restart",
          "[server][quota]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  REQUIRE(Ingest(engine, "walk", 1).ok());
  const auto clip = engine->store().GetClip("db", "walk");
  REQUIRE(clip.ok());
  CHECK(clip->byte_count > 61 * 60 * 4);
  CHECK(live->stored().byte_count == clip->byte_count);
  engine.Stop();
  engine.Start();
  const auto again = engine->FindDatabase("db");
  REQUIRE(again.ok());
  CHECK((*again)->stored().byte_count == clip->byte_count);
  REQUIRE(engine->DeleteClip("db", "walk").ok());
  CHECK((*again)->stored().byte_count == 0);
}

// A store in which another clip gets the id of a clip just before that clip is deleted.
class SwappingStore : public GatedStore {
 public:
  explicit SwappingStore(std::unique_ptr<storage::MotionStore> store)
      : GatedStore(std::move(store), std::make_shared<Gate>()) {}

  absl::StatusOr<storage::ClipRecord> DeleteClip(
      const std::string& database, const std::string& clip,
      const storage::WriteOptions& work_options) override {
    if (before_deletion) std::exchange(before_deletion, {})();
    return GatedStore::DeleteClip(database, clip, work_options);
  }

  std::function<void()> before_deletion;
};

TEST_CASE("Quota: a deletion is counted by the deleted clip, also if its id was reused",
          "[server][quota]") {
  auto memory = storage::SqliteMotionStore::Open(":memory:");
  REQUIRE(memory.ok());
  auto owned = std::make_unique<SwappingStore>(*std::move(memory));
  SwappingStore& store = *owned;
  const auto opened = server::Engine::Open(std::move(owned), With({}));
  REQUIRE(opened.ok());
  server::Engine& engine = **opened;
  REQUIRE(engine
              .CreateDatabase("db", {.frame_rate_hz = 60, .min_frames = 4},
                              {server::kSourceMarkerSet, ""})
              .ok());
  const auto live = *engine.FindDatabase("db");
  const auto ingest = [&](int frame_count) {
    storage::NewClip clip;
    clip.record.file_name = "walk.bvh";
    clip.file_bytes = WriteBvh({.act = Act::kWalk, .frame_count = frame_count});
    return engine.Ingest(live, {std::move(clip)}, {}).status();
  };
  REQUIRE(ingest(61).ok());
  store.before_deletion = [&] {
    REQUIRE(engine.DeleteClip("db", "walk").ok());
    REQUIRE(ingest(91).ok());
  };
  REQUIRE(engine.DeleteClip("db", "walk").ok());
  CHECK(live->stored().clip_count == 0);
  CHECK(live->stored().frame_count == 0);
  CHECK(live->stored().byte_count == 0);
}

TEST_CASE("Quota: the number of databases is limited", "[server][quota]") {
  server::EngineOptions options = TestEngine::QuickOptions();
  options.max_databases = 2;
  TestEngine engine(options);
  engine.Create("one");
  engine.Create("two");
  CheckExhausted(engine->CreateDatabase("three", {}, {}).status(), "--max-databases");
  REQUIRE(engine->DeleteDatabase("one").ok());
  CHECK(engine->CreateDatabase("three", {}, {.name = "standard34"}).ok());
}

}  // namespace
}  // namespace motiondb::tests::quota_test
