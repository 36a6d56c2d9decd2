// Verification names corrupt items, and nothing else.
#include "storage/sqlite/sqlite_verifier.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_verifier_test {
namespace {

using Catch::Contains;

// Clips "a" (three chunks of states), "b", and the deleted "gone", which the model still uses.
void Fill(const StoreFile& file) {
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  auto a = SampleClip("d", "a", 1);
  a.states = SampleStates(6000, 1);
  a.record.frame_count = 6000;
  REQUIRE_OK(store->AddClip(a));
  REQUIRE_OK(store->AddClip(SampleClip("d", "b", 2)));
  REQUIRE_OK(store->AddClip(SampleClip("d", "gone", 3)));
  REQUIRE_OK(
      store->PutModel("d", SampleModel({SampleClip("d", "b", 2), SampleClip("d", "gone", 3)})));
  REQUIRE_OK(store->DeleteClip("d", "gone"));
}

std::string FindingsAfter(const std::string& corruption) {
  const StoreFile file;
  Fill(file);
  file.Sql(corruption);
  return Findings(*file.Open());
}

}  // namespace

TEST_CASE("Verify: counts the content and finds nothing in an intact store", "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const auto store = file.Open();
  const auto verifier = Require(store->maintenance().BeginVerify({}));
  std::vector<storage::Corruption> found;
  double before = 0;
  REQUIRE(verifier->progress() == 0);
  while (Require(verifier->Step(found))) {
    REQUIRE(verifier->progress() >= before);
    before = verifier->progress();
  }
  REQUIRE(verifier->progress() == 1);
  REQUIRE(found.empty());
  const storage::VerifyTotals& totals = verifier->totals();
  REQUIRE(totals.database_count == 1);
  REQUIRE(totals.clip_count == 2);
  REQUIRE(totals.model_count == 1);
  REQUIRE(totals.skeleton_count == 1);
  REQUIRE(totals.byte_count > 6000 * (18 * 4 + 24));
  REQUIRE(totals.corruption_count == 0);
}

TEST_CASE("Verify: names corrupt items", "[storage][verify]") {
  SECTION("a clip's states, once, at the first corrupt chunk") {
    const std::string found =
        FindingsAfter(ChangeByte("clip_chunk", 70000, ChunksOf("a", 3) + " AND position = 1"));
    REQUIRE(found ==
            "databases/d/clips/a: states: chunk 1 is corrupt: its checksum does not match\n");
  }
  SECTION("a clip's file") {
    REQUIRE_THAT(FindingsAfter(ChangeByte("clip_chunk", 26, ChunksOf("b", 1))),
                 Contains("databases/d/clips/b: motion file: chunk 0 is corrupt"));
  }
  SECTION("a clip's missing skeleton file") {
    REQUIRE_THAT(FindingsAfter("DELETE FROM clip_chunk WHERE " + ChunksOf("b", 2)),
                 Contains("databases/d/clips/b: skeleton file: chunk 0 is missing"));
  }
  SECTION("states that do not belong to the clip") {
    REQUIRE_THAT(FindingsAfter("UPDATE clip SET root_path_crc = 1 WHERE id = 'b'"),
                 Contains("databases/d/clips/b: states: the root path does not match the clip\n"));
  }
  SECTION("a deleted clip that the model uses") {
    const std::string found = FindingsAfter(ChangeByte("clip_chunk", 100, ChunksOf("gone", 3)));
    REQUIRE_THAT(found, Contains("databases/d/models/1: deleted clip 'gone': states: chunk 0"));
  }
  SECTION("a skeleton") {
    REQUIRE_THAT(FindingsAfter(ChangeByte("skeleton_chunk", 60, "1")),
                 Contains("databases/d/skeletons/human: "));
  }
  SECTION("a model") {
    REQUIRE_THAT(FindingsAfter(ChangeByte("model_chunk", 100, "position = 0")),
                 Contains("databases/d/models/1: "));
  }
  SECTION("a model without one of its clips") {
    REQUIRE_THAT(FindingsAfter("DELETE FROM model_clip WHERE position = 1"),
                 Contains("databases/d/models/1: parts: expected 2 clips with 120 frames, got 1"));
  }
  SECTION("a model that does not match its rows") {
    REQUIRE_THAT(FindingsAfter("UPDATE model SET dimension_count = 17"),
                 Contains("databases/d/models/1: parts: expected 2 clips of 17 dimensions, got 2 "
                          "of 18"));
    REQUIRE_THAT(FindingsAfter("UPDATE model_clip SET position = 5 WHERE position = 0"),
                 Contains("databases/d/models/1: parts: its clip 'b' of 60 frames does not match"));
  }
  SECTION("a dangling reference") {
    REQUIRE_THAT(FindingsAfter("PRAGMA foreign_keys = OFF; UPDATE clip SET skeleton_key = 99 "
                               "WHERE id = 'b'"),
                 Contains("refers to a missing row of table skeleton"));
  }
  SECTION("unexpected tables") {
    REQUIRE(FindingsAfter("CREATE VIEW more AS SELECT * FROM clip") ==
            ": the file: unexpected view 'more'\n");
    REQUIRE(FindingsAfter("ANALYZE").empty());
  }
  SECTION("several items") {
    const std::string found = FindingsAfter(ChangeByte("clip_chunk", 26, ChunksOf("b", 1)) + ";" +
                                            ChangeByte("clip_chunk", 26, ChunksOf("a", 1)));
    REQUIRE(std::count(found.begin(), found.end(), '\n') == 2);
  }
}

TEST_CASE("Verify: a page that SQLite finds corrupt is reported for the file",
          "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  CorruptPage(file.path(), std::stol(file.Sql(RootPageOf("clip_by_content"))));
  REQUIRE_THAT(Findings(*file.Open()), Contains(": the file: "));
}

TEST_CASE("Verify: can be cancelled", "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const auto store = file.Open();
  bool stop = false;
  const auto verifier = Require(store->maintenance().BeginVerify([&] { return stop; }));
  std::vector<storage::Corruption> found;
  REQUIRE(Require(verifier->Step(found)));
  stop = true;
  REQUIRE_ERROR(verifier->Step(found), absl::StatusCode::kCancelled, "verification was cancelled");
}

TEST_CASE("Verify: runs concurrently with writes", "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const auto store = file.Open();
  const auto verifier = Require(store->maintenance().BeginVerify({}));
  std::vector<storage::Corruption> found;
  unsigned seed = 100;
  bool more = true;
  while (more) {
    more = Require(verifier->Step(found));
    REQUIRE_OK(store->AddClip(SampleClip("d", "new", ++seed)));
    if (seed == 102) REQUIRE_OK(store->DeleteClip("d", "b"));
  }
  REQUIRE(found.empty());
}

}  // namespace motiondb::tests::sqlite_verifier_test
