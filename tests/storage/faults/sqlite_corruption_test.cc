// Corruption of the file is detected and named; the rest stays readable.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_corruption_test {
namespace {

using absl::StatusCode;

// Two clips, "a" with three chunks of states and "b" with one, and a model of "b".
void Fill(const StoreFile& file) {
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  auto a = SampleClip("d", "a", 1);
  a.states = SampleStates(6000, 1);
  a.record.frame_count = 6000;
  const auto b = SampleClip("d", "b", 2);
  REQUIRE_OK(store->AddClip(a));
  REQUIRE_OK(store->AddClip(b));
  REQUIRE_OK(store->PutModel("d", SampleModel({b})));
}

const char kStatesOfA[] =
    "kind = 3 AND clip_key = (SELECT clip_key FROM clip WHERE id = 'a') AND position = 1";

}  // namespace

TEST_CASE("SqliteMotionStore: a corrupt chunk is named and the rest can be read",
          "[storage][corruption]") {
  const StoreFile file;
  Fill(file);
  for (const int place : {0, 9, 21, 24, 70000}) {
    const StoreFile copy;
    std::filesystem::copy_file(file.path(), copy.path());
    copy.Sql(ChangeByte("clip_chunk", place, kStatesOfA));
    const auto store = copy.Open();
    REQUIRE_ERROR(store->ReadClipStates("d", "a"), StatusCode::kDataLoss,
                  "database 'd', clip 'a': states: chunk 1 is corrupt");
    REQUIRE_OK(store->ReadClipSource("d", "a"));
    REQUIRE(Same(Require(store->ReadClipStates("d", "b")), SampleStates(60, 2)));
    REQUIRE_OK(store->ReadModel("d", core::RunSerially));
    REQUIRE(Require(store->ListClips("d", {})).size() == 2);
    // Remedy: delete the clip and ingest it again.
    REQUIRE_OK(store->DeleteClip("d", "a"));
    REQUIRE_OK(store->AddClip(SampleClip("d", "a", 1)));
  }
}

TEST_CASE("SqliteMotionStore: a missing chunk is named", "[storage][corruption]") {
  const StoreFile file;
  Fill(file);
  SECTION("in the middle") {
    file.Sql(std::string("DELETE FROM clip_chunk WHERE ") + kStatesOfA);
    REQUIRE_ERROR(file.Open()->ReadClipStates("d", "a"), StatusCode::kDataLoss, "clip 'a': states");
  }
  SECTION("all") {
    file.Sql("DELETE FROM clip_chunk WHERE kind = 1");
    REQUIRE_ERROR(file.Open()->ReadClipSource("d", "a"), StatusCode::kDataLoss,
                  "clip 'a': motion file: chunk 0 is missing");
  }
}

TEST_CASE("SqliteMotionStore: a corrupt model is named", "[storage][corruption]") {
  const StoreFile file;
  Fill(file);
  SECTION("in its own parts") {
    file.Sql(ChangeByte("model_chunk", 100, "position = 0"));
    REQUIRE_ERROR(file.Open()->ReadModel("d", core::RunSerially), StatusCode::kDataLoss,
                  "database 'd', model 1: parts: chunk 0 is corrupt");
  }
  SECTION("in the states of a clip") {
    file.Sql(ChangeByte("clip_chunk", 100,
                        "kind = 3 AND clip_key = (SELECT clip_key FROM clip WHERE id = 'b')"));
    REQUIRE_ERROR(file.Open()->ReadModel("d", core::RunSerially), StatusCode::kDataLoss,
                  "database 'd', model 1: clip 'b': states: chunk 0 is corrupt");
  }
  SECTION("in its list of clips") {
    file.Sql("DELETE FROM model_clip");
    REQUIRE_ERROR(file.Open()->ReadModel("d", core::RunSerially), StatusCode::kDataLoss,
                  "expected 1 clips, got 0");
  }
  SECTION("in its list of clips, with another clip") {
    file.Sql("UPDATE model_clip SET clip_key = (SELECT clip_key FROM clip WHERE id = 'a')");
    REQUIRE_ERROR(file.Open()->ReadModel("d", core::RunSerially), StatusCode::kDataLoss,
                  "expected 60 frames");
  }
  // A new model can replace it.
  REQUIRE_OK(file.Open()->PutModel("d", SampleModel({SampleClip("d", "b", 2)})));
}

TEST_CASE("SqliteMotionStore: a corrupt skeleton is named and does not prevent an ingest",
          "[storage][corruption]") {
  const StoreFile file;
  Fill(file);
  file.Sql(ChangeByte("skeleton_chunk", 60, "1"));
  const auto store = file.Open();
  REQUIRE_ERROR(store->GetSkeleton("d", "human"), StatusCode::kDataLoss, "skeleton 'human'");
  REQUIRE(Require(store->AddClip(SampleClip("d", "c", 3))).skeleton_id == "human-2");
  // Lists skip it.
  const auto listed = Require(store->ListSkeletons("d", {.limit = 1}));
  REQUIRE(listed.size() == 1);
  REQUIRE(listed[0].id == "human-2");
}

TEST_CASE("SqliteMotionStore: a page that SQLite finds corrupt is data loss",
          "[storage][corruption]") {
  const StoreFile file;
  Fill(file);
  const auto page = std::stol(file.Sql("SELECT rootpage FROM sqlite_schema WHERE name = 'clip'"));
  {
    std::fstream bytes(file.path(), std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp((page - 1) * 16384);
    bytes << std::string(64, '\x7f');
  }
  const auto store = file.Open();
  REQUIRE_ERROR(store->ListClips("d", {}), StatusCode::kDataLoss, "malformed");
  REQUIRE_OK(store->GetDatabase("d"));
}

}  // namespace motiondb::tests::sqlite_corruption_test
