#include "tests/storage/conformance/clip_conformance.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/storage/faults/store_pages.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::ClipRecord;
using storage::NewClip;

}  // namespace

ClipRecord Expected(const NewClip& clip, const std::string& id, const std::string& skeleton_id) {
  ClipRecord record = clip.record;
  record.id = id;
  record.skeleton_id = skeleton_id;
  return record;
}

void TestClips(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  NewClip walk = SampleClip("d", "walk", 1);
  walk.states.states(3, 4) = std::nanf("");
  const ClipRecord added = Require(store->AddClip(walk));
  REQUIRE(Same(added, Expected(walk, "walk", added.skeleton_id)));
  REQUIRE_FALSE(added.skeleton_id.empty());
  REQUIRE(Same(Require(store->GetClip("d", "walk")), added));
  REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), walk.states));
  const auto source = Require(store->ReadClipSource("d", "walk"));
  REQUIRE(source.file_bytes == walk.file_bytes);
  REQUIRE(source.skeleton_bytes == walk.skeleton_bytes);

  SECTION("bare markers have no skeleton") {
    NewClip bare = SampleClip("d", "bare", 2);
    bare.skeleton.reset();
    bare.skeleton_bytes.clear();
    bare.record.skeleton_file_name.clear();
    bare.record.format = core::FileFormat::kTrc;
    REQUIRE(Same(Require(store->AddClip(bare)), Expected(bare, "bare", "")));
    REQUIRE(Require(store->ReadClipSource("d", "bare")).skeleton_bytes.empty());
  }
  SECTION("an existing id gets a number") {
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk", 2))).id == "walk-2");
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk", 3))).id == "walk-3");
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk-2", 4))).id == "walk-2-2");
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk-2")), SampleStates(60, 2)));
    REQUIRE_OK(store->DeleteClip("d", "walk-2"));
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk", 5))).id == "walk-2");
  }
  SECTION("unless it is fixed") {
    NewClip fixed = SampleClip("d", "walk", 2);
    fixed.id_is_fixed = true;
    REQUIRE_ERROR(store->AddClip(fixed), StatusCode::kAlreadyExists, "'walk'");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"walk"});
    fixed.record.id = "run";
    REQUIRE(Require(store->AddClip(fixed)).id == "run");
  }
  SECTION("the same content is stored once in a database") {
    REQUIRE_ERROR(store->AddClip(SampleClip("d", "other", 1)), StatusCode::kAlreadyExists,
                  "'walk'");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"walk"});
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
    REQUIRE_OK(store->AddClip(SampleClip("e", "other", 1)));
  }
  SECTION("the audit entry contains the stored id and is written only with the clip") {
    NewClip noted = SampleClip("d", "walk", 2);
    noted.audit = [](const ClipRecord& stored) {
      return storage::AuditRecord{.method = "Ingest", .resource = stored.id};
    };
    REQUIRE_OK(store->AddClip(noted));
    REQUIRE_ERROR(store->AddClip(noted), StatusCode::kAlreadyExists, "walk-2");
    const auto entries = Require(store->access().ListAuditRecords(0, 10));
    REQUIRE(entries.size() == 1);
    REQUIRE(entries[0].method == "Ingest");
    REQUIRE(entries[0].resource == "walk-2");
  }
  SECTION("lists are in order of id, in pages") {
    for (unsigned i = 2; i < 8; ++i) {
      REQUIRE_OK(store->AddClip(SampleClip("d", "c" + std::to_string(17 * i % 10), i)));
    }
    const std::vector<std::string> ids{"c1", "c2", "c4", "c5", "c8", "c9", "walk"};
    for (const int limit : {1, 3, 7, 100}) REQUIRE(ClipIds(store, "d", limit) == ids);
  }
  SECTION("a deleted clip is not found and can be added again") {
    const auto before = Require(store->GetClip("d", "walk"));
    const auto deleted = Require(store->DeleteClip("d", "walk"));
    REQUIRE(deleted.id == "walk");
    REQUIRE(deleted.content_hash == before.content_hash);
    REQUIRE(deleted.frame_count == before.frame_count);
    REQUIRE(deleted.byte_count == before.byte_count);
    REQUIRE(deleted.skeleton_id == before.skeleton_id);
    REQUIRE_ERROR(store->GetClip("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->DeleteClip("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->ReadClipStates("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->ReadClipSource("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE(ClipIds(store, "d", 10).empty());
    REQUIRE(Require(store->AddClip(walk)).id == "walk");
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), walk.states));
  }
  SECTION("unknown names are not found") {
    REQUIRE_ERROR(store->AddClip(SampleClip(kUnknown, "walk", 2)), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->GetClip("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->GetClip(kUnknown, "walk"), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ListClips(kUnknown, {}), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->DeleteClip("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ReadClipStates("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ReadClipSource("d", kUnknown), StatusCode::kNotFound, kUnknown);
  }
  SECTION("a wrong frame count is refused") {
    NewClip wrong = SampleClip("d", "wrong", 2);
    wrong.record.frame_count = 7;
    REQUIRE_ERROR(store->AddClip(wrong), StatusCode::kInvalidArgument, "wrong");
    NewClip uneven = SampleClip("d", "uneven", 2);
    uneven.states.root_path.conservativeResize(5, 3);
    REQUIRE_ERROR(store->AddClip(uneven), StatusCode::kInvalidArgument, "root pose");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"walk"});
  }
  SECTION("large files and long clips are stored completely") {
    NewClip large = SampleClip("d", "large", 2);
    large.states = SampleStates(9000, 2);
    large.record.frame_count = 9000;
    large.file_bytes.assign(3 * 256 * 1024, 'x');  // a whole number of chunks
    large.skeleton_bytes.assign(256 * 1024 + 1, 'y');
    REQUIRE_OK(store->AddClip(large));
    REQUIRE(Same(Require(store->ReadClipStates("d", "large")), large.states));
    const auto back = Require(store->ReadClipSource("d", "large"));
    REQUIRE(back.file_bytes == large.file_bytes);
    REQUIRE(back.skeleton_bytes == large.skeleton_bytes);
  }
}

void TestMarkerSetOfFirstClip(StoreUnderTest& store) {
  auto database = SampleDatabase("d");
  database.marker_set = "source";
  database.marker_set_text.clear();
  REQUIRE_OK(store->CreateDatabase(database));
  NewClip first = SampleClip("d", "first", 1);
  first.marker_set_text = "its own markers";
  REQUIRE_OK(store->AddClip(first));
  database.marker_set_text = "its own markers";
  REQUIRE(Same(Require(store->GetDatabase("d")), database));

  NewClip second = SampleClip("d", "second", 2);
  second.marker_set_text = "other markers";
  REQUIRE_ERROR(store->AddClip(second), StatusCode::kFailedPrecondition, "marker set");
  REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"first"});
  second.marker_set_text = "its own markers";
  REQUIRE_OK(store->AddClip(second));
  REQUIRE(Same(Require(store->GetDatabase("d")), database));
}

void TestSkeletons(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  NewClip tall = SampleClip("d", "tall", 3);
  tall.skeleton = SampleSkeleton("human", 0.5);
  NewClip odd = SampleClip("d", "odd", 4);
  odd.skeleton = SampleSkeleton("a/b c");
  const std::string first = Require(store->AddClip(SampleClip("d", "one", 1))).skeleton_id;
  const std::string again = Require(store->AddClip(SampleClip("d", "two", 2))).skeleton_id;
  const std::string second = Require(store->AddClip(tall)).skeleton_id;
  const std::string third = Require(store->AddClip(odd)).skeleton_id;
  REQUIRE(first == again);
  REQUIRE(first != second);
  // Skeleton ids are parts of resource names.
  REQUIRE(third.find_first_of("/ ") == std::string::npos);
  REQUIRE(Same(Require(store->GetSkeleton("d", first)), SampleSkeleton("human")));
  REQUIRE(Same(Require(store->GetSkeleton("d", second)), *tall.skeleton));
  REQUIRE(Same(Require(store->GetSkeleton("d", third)), *odd.skeleton));
  REQUIRE_ERROR(store->GetSkeleton("d", kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->GetSkeleton(kUnknown, first), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ListSkeletons(kUnknown, {}), StatusCode::kNotFound, kUnknown);

  const auto ids = [&](int limit) {
    return AllPages(
        limit, [&](const storage::Page& page) { return store->ListSkeletons("d", page); },
        [](const storage::SkeletonRecord& record) { return record.id; });
  };
  std::vector<std::string> expected{first, second, third};
  std::sort(expected.begin(), expected.end());
  REQUIRE(ids(1) == expected);
  REQUIRE(ids(10) == expected);

  // A skeleton stays as long as a clip uses it.
  REQUIRE_OK(store->DeleteClip("d", "tall"));
  REQUIRE_OK(store->DeleteClip("d", "one"));
  REQUIRE_ERROR(store->GetSkeleton("d", second), StatusCode::kNotFound, second);
  REQUIRE(Same(Require(store->GetSkeleton("d", first)), SampleSkeleton("human")));
}

}  // namespace motiondb::tests
