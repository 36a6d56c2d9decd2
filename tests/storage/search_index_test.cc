// The search index is derived from the rows: its corruption prevents neither changes nor searches.
#include <catch2/catch.hpp>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/storage/add_together.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::search_index_test {
namespace {

using absl::StatusCode;
using storage::SqliteMotionStore;

absl::Status SetTitle(SqliteMotionStore& store, const std::string& clip, const std::string& title) {
  storage::ClipChange change;
  change.clip = clip;
  change.title = title;
  change.tags = {{"some tag", title}};
  return store.Edit("d", std::vector<storage::Change>{change}, "me").status();
}

// Three clips, and an edit of the first.
void Fill(SqliteMotionStore& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  for (unsigned i = 1; i < 4; ++i) {
    REQUIRE_OK(store.AddClip(SampleClip("d", "clip" + std::to_string(i), i)));
  }
  REQUIRE_OK(SetTitle(store, "clip1", "former"));
}
constexpr std::int64_t kFirstEdit = 4;

// Returns the sorted answers to searches that find all, some and no clips.
std::string Answers(SqliteMotionStore& store) {
  std::string answers;
  for (const std::string query : {"walk", "w*", "\"quite other\"", "tag", "new*", "absent"}) {
    std::set<std::string> matches;
    for (const auto& match : Require(store.SearchClips("d", query))) {
      matches.insert(match.clip + " " + std::to_string(match.score) + "; ");
    }
    answers += query + ": ";
    for (const std::string& match : matches) answers += match;
  }
  return answers;
}

struct Use {
  std::string name;
  std::function<absl::Status(SqliteMotionStore&)> run;
};

const std::vector<Use> kUses = {
    {"add", [](auto& store) { return store.AddClip(SampleClip("d", "new", 9)).status(); }},
    {"edit", [](auto& store) { return SetTitle(store, "clip1", "news"); }},
    {"undo", [](auto& store) { return store.UndoEdit("d", kFirstEdit, "me").status(); }},
    {"replace",
     [](auto& store) {
       const auto former = Require(store.GetClip("d", "clip1"));
       return store.ReplaceClip(former, SampleClip("d", "clip1", 8)).status();
     }},
    {"delete", [](auto& store) { return store.DeleteClip("d", "clip1").status(); }},
    {"search", [](auto& store) { return store.SearchClips("d", "walk").status(); }},
};

void UseAndChange(SqliteMotionStore& store, const Use& use) {
  REQUIRE_OK(use.run(store));
  REQUIRE_OK(store.AddClip(SampleClip("d", "last", 10)));
  REQUIRE_OK(SetTitle(store, "clip3", "quite other"));
  REQUIRE_OK(store.DeleteClip("d", "clip2"));
}

storage::SqliteOptions AtNoon() {
  return {.now_us = [] { return std::int64_t{1'700'000'000'000'000}; }};
}

void Corrupt(const StoreFile& file, const std::string& what) {
  if (what.starts_with("clip_text")) {
    CorruptPage(file.path(), std::stol(file.Sql(RootPageOf(what))));
  } else {
    file.Sql(what);
  }
}

}  // namespace

TEST_CASE("Search index: a corrupt one is rebuilt by the first change or search that meets it",
          "[storage][index]") {
  const std::string what = GENERATE(
      "clip_text_data", "clip_text_idx", "clip_text_content", "clip_text_docsize",
      "clip_text_config", "DELETE FROM clip_text_data", "DELETE FROM clip_text_data WHERE id = 10",
      "UPDATE clip_text_data SET block = zeroblob(10) WHERE id = 10",
      "UPDATE clip_text_data SET block = x'00' WHERE id > 10", "DELETE FROM clip_text_config",
      "DROP TABLE clip_text_docsize",
      "INSERT INTO clip_text_content (id) VALUES (4)");  // a row that was left
  for (const Use& use : kUses) {
    INFO(what << ", " << use.name);
    const StoreFile file;
    { Fill(*file.Open(AtNoon())); }
    Corrupt(file, what);
    int rebuilt = 0;
    auto options = AtNoon();
    options.on_index_rebuild = [&](const absl::Status& status) { rebuilt += status.ok() ? 1 : 99; };
    auto store = file.Open(std::move(options));
    UseAndChange(*store, use);
    const StoreFile fresh_file;
    const auto fresh = fresh_file.Open(AtNoon());
    Fill(*fresh);
    UseAndChange(*fresh, use);

    CHECK(Answers(*store) == Answers(*fresh));
    CHECK(rebuilt == 1);
    CHECK(Dump(*store) == Dump(*fresh));
    CHECK(Findings(*store).empty());
    store.reset();
    store = file.Open();
    CHECK(Answers(*store) == Answers(*fresh));
    CHECK(Findings(*store).empty());
  }
}

TEST_CASE("Search index: additions that share a commit rebuild it", "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  Corrupt(file, GENERATE("clip_text_data", "clip_text_content"));
  const auto store = file.Open();
  std::vector<storage::NewClip> clips;
  for (unsigned i = 20; i < 25; ++i) clips.push_back(SampleClip("d", std::to_string(i), i));
  const auto added = AddTogether(*store, SampleClip("d", "holder", 19), clips, {});
  for (const auto& result : added) REQUIRE_OK(result.added);
  REQUIRE(Require(store->SearchClips("d", "walk")).size() == 9);
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Search index: verify reports wrong words, and the next change or search repairs them",
          "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  file.Sql("UPDATE clip_text_content SET c0 = 'another title' WHERE id = 2");
  const auto store = file.Open();
  REQUIRE_OK(store->SearchClips("d", "walk"));
  for (int i = 0; i < 2; ++i) {
    REQUIRE_THAT(Findings(*store),
                 Catch::Contains("databases/d/clips/clip2: search index: ") &&
                     Catch::Contains("the next change or search rebuilds the index"));
  }
  SECTION("a change") { REQUIRE_OK(store->PutOperation(SampleOperation("d", "op"))); }
  SECTION("a search") { REQUIRE_OK(store->SearchClips("d", "walk")); }
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Search index: a corrupt one is reported by a read-only store", "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  Corrupt(file, "clip_text_data");
  const auto store = file.Open({.read_only = true});
  for (int i = 0; i < 2; ++i) {
    REQUIRE_ERROR(store->SearchClips("d", "walk"), StatusCode::kDataLoss,
                  "without --read-only, a search rebuilds it");
    REQUIRE_THAT(Findings(*store), Catch::Contains("search index"));
  }
}

TEST_CASE("Search index: an import or purge that meets a corrupt one succeeds if repeated",
          "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  Corrupt(file, GENERATE("clip_text_data", "clip_text_content"));
  const auto store = file.Open();
  SECTION("import") {
    const std::string bytes = Export(*store, "d");
    REQUIRE(absl::IsDataLoss(Import(*store, bytes, "e")));
    REQUIRE_OK(Import(*store, bytes, "e"));
    REQUIRE(Require(store->SearchClips("e", "walk")).size() == 3);
  }
  SECTION("purge") {
    REQUIRE_OK(store->DeleteDatabase("d"));
    store->PurgeDeletedDatabases({}).IgnoreError();
    REQUIRE_OK(store->PurgeDeletedDatabases({}));
  }
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Search index: a backup with a corrupt one can be restored and imported",
          "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  Corrupt(file, GENERATE("clip_text_data", "clip_text_config",
                         "UPDATE clip_text_content SET c0 = 'another title' WHERE id = 2"));
  const auto store = file.Open();
  const std::string bytes = Backup(*store);
  const StoreFile to;
  const auto target = to.Open();
  SECTION("restored") { REQUIRE_OK(Restore(*target, bytes)); }
  SECTION("imported") { REQUIRE_OK(Import(*target, bytes, "d")); }
  REQUIRE(Answers(*target) == Answers(*store));
  REQUIRE(Findings(*target).empty());
}

TEST_CASE("Search index: of corrupt clips none is made, and the clips stay", "[storage][index]") {
  const StoreFile file;
  { Fill(*file.Open()); }
  Corrupt(file, "clip_text_data");
  CorruptPage(file.path(), std::stol(file.Sql(RootPageOf("segment"))));
  absl::Status rebuilt;
  storage::SqliteOptions options;
  options.on_index_rebuild = [&](const absl::Status& status) { rebuilt = status; };
  const auto store = file.Open(std::move(options));
  REQUIRE(absl::IsDataLoss(store->SearchClips("d", "walk").status()));
  REQUIRE(absl::IsDataLoss(rebuilt));
  REQUIRE(Require(store->ListClips("d", {})).size() == 3);
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
}

}  // namespace motiondb::tests::search_index_test
