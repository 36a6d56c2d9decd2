// Annotations of SqliteMotionStore beyond conformance: more random edits, concurrent editors,
// limits of what is kept, and corruption.
#include <catch2/catch.hpp>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "storage/blob/annotation_codec.h"
#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::annotation_test {
namespace {

using absl::StatusCode;
using Catch::Contains;
using Changes = std::vector<storage::Change>;

class InMemory final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override { return *store_; }

 private:
  std::unique_ptr<storage::SqliteMotionStore> store_ =
      Require(storage::SqliteMotionStore::Open(":memory:"));
};

storage::ClipChange TitleOf(const std::string& clip, const std::string& title) {
  storage::ClipChange change;
  change.clip = clip;
  change.title = title;
  return change;
}

storage::SegmentCreation SegmentOf(const std::string& clip, const std::string& id) {
  storage::SegmentCreation creation;
  creation.segment.clip = clip;
  creation.segment.id = id;
  creation.segment.track = "t";
  creation.segment.label = "some word";
  creation.segment.end_seconds = 1;
  return creation;
}

// Clips "a" and "b", with a segment "s" and an edit of "a".
void Fill(storage::MotionStore& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "a", 1)));
  REQUIRE_OK(store.AddClip(SampleClip("d", "b", 2)));
  auto title = TitleOf("a", "Title");
  title.tags = {{"tag"}};
  REQUIRE_OK(store.annotations().Edit("d", Changes{SegmentOf("a", "s"), title}, "me"));
}

void OverwritePage(const StoreFile& file, const std::string& table) {
  const long page = std::stol(file.Sql(RootPageOf(table)));
  std::fstream bytes(file.path(), std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp((page - 1) * 16384);
  bytes << std::string(64, '\x7f');
}

}  // namespace

TEST_CASE("Annotations: many random edits have the effect that a simple model has",
          "[storage][annotations]") {
  const auto seed = GENERATE(range(10u, 16u));
  InMemory store;
  TestRandomEdits(store, seed, 400);
}

TEST_CASE("Annotations: replicas follow many random changes", "[storage][annotations]") {
  const auto seed = GENERATE(range(10u, 16u));
  InMemory store;
  TestReplicas(store, seed, 400);
  REQUIRE(Findings(store.Get()).find("checksum") == std::string::npos);
}

TEST_CASE("Annotations: concurrent editors with etags lose no change", "[storage][annotations]") {
  const StoreFile file;
  const auto store = file.Open();
  Fill(*store);
  constexpr int kEditors = 4;
  constexpr int kEdits = 25;
  std::vector<int> aborted(kEditors);
  std::vector<absl::Status> errors(kEditors);
  std::vector<std::jthread> editors;
  for (std::size_t e = 0; e < kEditors; ++e) {
    editors.emplace_back([&, e] {
      for (int done = 0; done < kEdits && errors[e].ok();) {
        const auto clip = store->GetClip("d", "b");
        if (!clip.ok()) errors[e] = clip.status();
        if (!clip.ok()) return;
        auto change = TitleOf("b", clip->title + "x");
        change.revision = clip->revision;
        const auto edit = store->annotations().Edit("d", Changes{change}, "me");
        if (edit.ok()) {
          ++done;
        } else if (absl::IsAborted(edit.status())) {
          ++aborted[e];
        } else {
          errors[e] = edit.status();
        }
      }
    });
  }
  editors.clear();
  for (const absl::Status& error : errors) REQUIRE_OK(error);
  REQUIRE(Require(store->GetClip("d", "b")).title == std::string(kEditors * kEdits, 'x'));
  REQUIRE(Require(store->annotations().ListEdits("d", "b", 0, 1000)).size() == kEditors * kEdits);
}

TEST_CASE("Annotations: the last 10,000 edits are kept", "[storage][annotations]") {
  const StoreFile file;
  Fill(*file.Open());
  file.Sql("UPDATE edit SET number = 9999");
  const auto store = file.Open();
  const auto ids = [&] {
    std::string text;
    for (const auto& edit : Require(store->annotations().ListEdits("d", "", 0, 10))) {
      text += std::to_string(edit.id) + " ";
    }
    return text;
  };
  for (const char* const title : {"1", "2", "3"}) {
    REQUIRE_OK(store->annotations().Edit("d", Changes{TitleOf("a", title)}, "me"));
  }
  // Numbers 9,999 to 10,002: number 2 would be the first that is kept.
  REQUIRE(ids() == "6 5 4 3 ");
  file.Sql("UPDATE edit SET number = 20000 WHERE revision = 6");
  REQUIRE_OK(store->annotations().Edit("d", Changes{TitleOf("a", "4")}, "me"));
  REQUIRE(ids() == "7 6 ");
  REQUIRE_ERROR(store->annotations().UndoEdit("d", 4, ""), StatusCode::kNotFound, "10000");
}

TEST_CASE("Annotations: the last 100,000 deletions are kept", "[storage][annotations]") {
  const StoreFile file;
  Fill(*file.Open());
  const auto store = file.Open();
  auto& annotations = store->annotations();
  const auto remove = [&](const std::string& id) {
    const storage::Change create = SegmentOf("b", id);
    REQUIRE_OK(annotations.Edit("d", Changes{create}, ""));
    REQUIRE_OK(annotations.Edit("d", Changes{storage::SegmentDeletion{"b", id}}, ""));
    return Require(annotations.Revision("d"));
  };
  const std::int64_t first = remove("1");
  const std::int64_t second = remove("2");
  REQUIRE_OK(annotations.Changes("d", 1, 10));
  file.Sql("UPDATE tombstone SET number = 100001 WHERE segment = '2'");
  const std::int64_t third = remove("3");
  REQUIRE(third > second);
  REQUIRE_ERROR(annotations.Changes("d", 1, 10), StatusCode::kOutOfRange,
                "after revision 1 are no longer complete");
  REQUIRE_OK(annotations.Changes("d", first, 10));
  REQUIRE_OK(annotations.Changes("d", 0, 10));
  // A reader that began later, from 0 on, needs no earlier deletions.
  REQUIRE_OK(annotations.Changes("d", 1, 10, first));
  REQUIRE_ERROR(annotations.Changes("d", 1, 10, first - 1), StatusCode::kOutOfRange, "complete");
}

TEST_CASE("Annotations: corrupt bytes of an edit or of tags are data loss",
          "[storage][annotations]") {
  storage::ClipRecord clip;
  clip.id = "walk";
  clip.tags = {"a", "b"};
  clip.fields = {{"n", 1.5}, {"s", std::string("x")}, {"f", true}, {"t", storage::FieldTime{7}}};
  storage::SegmentRecord segment;
  segment.clip = "walk";
  segment.id = "s";
  segment.end_seconds = 1;
  const std::vector<storage::EditedObject> objects = {
      {clip, clip}, {std::nullopt, segment}, {segment, std::nullopt}};
  const std::string bytes = Require(storage::EncodeObjects(objects));
  const auto decode = [](const std::string& of) {
    return storage::DecodeObjects("d", std::as_bytes(std::span(of)));
  };
  const auto back = Require(decode(bytes));
  REQUIRE(Require(storage::EncodeObjects(back)) == bytes);
  REQUIRE(std::get<storage::ClipRecord>(*back[0].after).fields == clip.fields);
  REQUIRE(std::get<storage::SegmentRecord>(*back[1].after).database == "d");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    REQUIRE_ERROR(decode(bytes.substr(0, size)), StatusCode::kDataLoss, "");
  }
  REQUIRE_ERROR(decode(bytes + "x"), StatusCode::kDataLoss, "");
  for (std::size_t place = 0; place < bytes.size(); ++place) {
    for (const char value : {'\0', '\x07', '\xff'}) {
      std::string changed = bytes;
      changed[place] = value;
      const auto decoded = decode(changed);
      if (decoded.ok()) continue;  // another text or number
      REQUIRE(decoded.status().code() == StatusCode::kDataLoss);
    }
  }
  const std::string annotations = Require(storage::EncodeAnnotations(clip));
  for (std::size_t size = 0; size < annotations.size(); ++size) {
    storage::ClipRecord read;
    REQUIRE_ERROR(
        storage::DecodeAnnotations(std::as_bytes(std::span(annotations.data(), size)), read),
        StatusCode::kDataLoss, "");
  }
}

TEST_CASE("Annotations: verify names a corrupt edit and a changed search index",
          "[storage][verify]") {
  const auto [change, found] = GENERATE(table<std::string, std::string>({
      {"UPDATE edit SET objects = substr(objects, 1, 20)",
       "databases/d/edits/3: database 'd', edit"},
      {"UPDATE clip SET annotations = x'0102' WHERE id = 'a'",
       "databases/d/clips/a: database 'd', clip 'a': tags and fields: "},
      {"DELETE FROM clip_text WHERE rowid = 1",
       "databases/d/clips/a: search index: the clip is missing"},
      {"UPDATE clip_text SET labels = 'other' WHERE rowid = 1",
       "databases/d/clips/a: search index: 'labels' differs from the clip"},
      {"UPDATE clip_text_content SET c0 = 'other' WHERE id = 1",
       "databases/d/clips/a: search index: 'title' differs from the clip"},
      // The index has entries that the text lacks, and the reverse.
      {"UPDATE clip_text_content SET c1 = 'more' WHERE id = 1",
       "databases/d/clips/a: search index: its words differ from the clip"},
      {"UPDATE clip_text_content SET c5 = '' WHERE id = 1",
       "databases/d/clips/a: search index: its words differ from the clip"},
      {"DELETE FROM clip_text_data WHERE id > 10", "search index"},
      {"DELETE FROM clip_text_data WHERE id = 10", "search index"},
  }));
  const StoreFile file;
  Fill(*file.Open());
  file.Sql(change);
  const auto store = file.Open();
  CHECK_THAT(Findings(*store), Contains(found));
  // Everything else is served.
  CHECK(Require(store->GetClip("d", "b")).label == "walk");
  CHECK(Require(store->annotations().ListSegments("d", "a")).size() == 2);
  CHECK_THAT(Findings(*store), !Contains("clips/b: tags"));
}

TEST_CASE("Annotations: a corrupt page of the search index or of edits does not affect the rest",
          "[storage][corruption]") {
  const std::string table =
      GENERATE("clip_text_data", "clip_text_content", "clip_text_idx", "edit");
  INFO(table);
  const StoreFile file;
  Fill(*file.Open());
  OverwritePage(file, table);
  const auto store = file.Open();
  CHECK_FALSE(Findings(*store).empty());
  if (table == "edit") CHECK_FALSE(store->annotations().ListEdits("d", "", 0, 10).ok());
  REQUIRE_OK(store->annotations().SearchClips("d", "walk"));
  REQUIRE(Require(store->ListClips("d", {})).size() == 2);
  REQUIRE_OK(store->annotations().ListSegments("d", "a"));
  REQUIRE_OK(store->annotations().Changes("d", 0, 10));
  REQUIRE_OK(store->ReadClipStates("d", "a"));
  REQUIRE_OK(store->DeleteClip("d", "b"));
}

TEST_CASE("Annotations: a corrupt page of segments is data loss; motion is served",
          "[storage][corruption]") {
  const StoreFile file;
  Fill(*file.Open());
  OverwritePage(file, "segment");
  const auto store = file.Open();
  CHECK_THAT(Findings(*store), Contains("segment"));
  REQUIRE_ERROR(store->annotations().ListSegments("d", "a"), StatusCode::kDataLoss, "malformed");
  REQUIRE_OK(store->ReadClipStates("d", "a"));
  REQUIRE_OK(store->ReadClipSource("d", "a"));
  REQUIRE(Require(store->ListClips("d", {})).size() == 2);
  REQUIRE_OK(store->GetDatabase("d"));
}

}  // namespace motiondb::tests::annotation_test
