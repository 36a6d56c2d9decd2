#include "tests/storage/motion_store_conformance.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/model/extend_model.h"
#include "tests/storage/access_store_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::ClipRecord;
using storage::NewClip;

constexpr char kUnknown[] = "no-such-thing";

// Ids or names of a list, read in pages of `limit`.
template <typename List, typename Key>
std::vector<std::string> AllPages(int limit, const List& list, const Key& key) {
  std::vector<std::string> keys;
  storage::Page page{.after = "", .limit = limit};
  while (true) {
    const auto records = Require(list(page));
    REQUIRE(static_cast<int>(records.size()) <= limit);
    for (const auto& record : records) keys.push_back(key(record));
    if (static_cast<int>(records.size()) < limit) return keys;
    page.after = keys.back();
  }
}

std::vector<std::string> ClipIds(StoreUnderTest& store, const std::string& database, int limit) {
  return AllPages(
      limit, [&](const storage::Page& page) { return store->ListClips(database, page); },
      [](const ClipRecord& record) { return record.id; });
}

// The record that a store must give back for a new clip.
ClipRecord Expected(const NewClip& clip, const std::string& id, const std::string& skeleton_id) {
  ClipRecord record = clip.record;
  record.id = id;
  record.skeleton_id = skeleton_id;
  return record;
}

void TestDatabases(StoreUnderTest& store) {
  const auto record = SampleDatabase("walks");
  REQUIRE_OK(store->CreateDatabase(record));
  REQUIRE(Same(Require(store->GetDatabase("walks")), record));
  REQUIRE_ERROR(store->CreateDatabase(record), StatusCode::kAlreadyExists, "walks");
  REQUIRE_ERROR(store->GetDatabase(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->DeleteDatabase(kUnknown), StatusCode::kNotFound, kUnknown);

  auto other = SampleDatabase("box es/%'\"\xc3\xa9");  // any text is a name to a store
  other.settings = {.frame_rate_hz = 29.97, .min_frames = 16, .scaling = core::Scaling::kNone};
  other.marker_set_text = std::string("line\r\n\0more", 11);
  REQUIRE_OK(store->CreateDatabase(other));
  REQUIRE(Same(Require(store->GetDatabase(other.name)), other));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("Zumba")));
  const std::vector<std::string> names{"Zumba", other.name, "walks"};
  for (const int limit : {1, 2, 3, 10}) {
    REQUIRE(names == AllPages(
                         limit,
                         [&](const storage::Page& page) { return store->ListDatabases(page); },
                         [](const auto& database) { return database.name; }));
  }

  REQUIRE_OK(store->DeleteDatabase("walks"));
  REQUIRE_ERROR(store->GetDatabase("walks"), StatusCode::kNotFound, "walks");
  REQUIRE_OK(store->CreateDatabase(record));
}

void TestDeleteDatabaseWithAll(StoreUnderTest& store) {
  for (const char* name : {"a", "b"}) {
    REQUIRE_OK(store->CreateDatabase(SampleDatabase(name)));
    const NewClip clip = SampleClip(name, "walk", 1);
    REQUIRE_OK(store->AddClip(clip));
    REQUIRE_OK(store->PutModel(name, SampleModel({clip})));
    REQUIRE_OK(store->PutOperation(SampleOperation(name, std::string("op-") + name)));
  }
  REQUIRE_OK(store->DeleteDatabase("a"));
  REQUIRE_ERROR(store->GetClip("a", "walk"), StatusCode::kNotFound, "a");
  REQUIRE_ERROR(store->ReadModel("a", core::Serially), StatusCode::kNotFound, "a");
  REQUIRE_ERROR(store->GetOperation("op-a"), StatusCode::kNotFound, "op-a");
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("a")));
  REQUIRE(ClipIds(store, "a", 10).empty());
  REQUIRE(Require(store->ListModels("a", 0, 10)).empty());
  REQUIRE(Require(store->ListSkeletons("a", {})).empty());
  REQUIRE(Require(store->ListOperations("a", "", 10)).empty());

  REQUIRE(Require(store->GetClip("b", "walk")).id == "walk");
  REQUIRE_OK(store->ReadModel("b", core::Serially));
  REQUIRE_OK(store->GetOperation("op-b"));
  REQUIRE(Require(store->ListOperations("", "", 10)).size() == 1);
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
  SECTION("an id that is taken gets a number") {
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
  SECTION("lists are in order of id, in pages") {
    for (unsigned i = 2; i < 8; ++i) {
      REQUIRE_OK(store->AddClip(SampleClip("d", "c" + std::to_string(17 * i % 10), i)));
    }
    const std::vector<std::string> ids{"c1", "c2", "c4", "c5", "c8", "c9", "walk"};
    for (const int limit : {1, 3, 7, 100}) REQUIRE(ClipIds(store, "d", limit) == ids);
  }
  SECTION("a deleted clip is gone, and may come back") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_ERROR(store->GetClip("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->DeleteClip("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->ReadClipStates("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE_ERROR(store->ReadClipSource("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE(ClipIds(store, "d", 10).empty());
    REQUIRE(Require(store->AddClip(walk)).id == "walk");
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), walk.states));
  }
  SECTION("what is not there is not found") {
    REQUIRE_ERROR(store->AddClip(SampleClip(kUnknown, "walk", 2)), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->GetClip("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->GetClip(kUnknown, "walk"), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ListClips(kUnknown, {}), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->DeleteClip("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ReadClipStates("d", kUnknown), StatusCode::kNotFound, kUnknown);
    REQUIRE_ERROR(store->ReadClipSource("d", kUnknown), StatusCode::kNotFound, kUnknown);
  }
  SECTION("a record that does not tell its frames is refused") {
    NewClip wrong = SampleClip("d", "wrong", 2);
    wrong.record.frame_count = 7;
    REQUIRE_ERROR(store->AddClip(wrong), StatusCode::kInvalidArgument, "wrong");
    NewClip uneven = SampleClip("d", "uneven", 2);
    uneven.states.root_path.conservativeResize(5, 3);
    REQUIRE_ERROR(store->AddClip(uneven), StatusCode::kInvalidArgument, "root pose");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"walk"});
  }
  SECTION("large files and long clips come back whole") {
    NewClip large = SampleClip("d", "large", 2);
    large.states = SampleStates(9000, 2);
    large.record.frame_count = 9000;
    large.file_bytes.assign(3 * 256 * 1024, 'x');  // ends where a chunk may
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
  // Skeleton ids stand in resource names.
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

  // A skeleton stays as long as a clip is on it.
  REQUIRE_OK(store->DeleteClip("d", "tall"));
  REQUIRE_OK(store->DeleteClip("d", "one"));
  REQUIRE_ERROR(store->GetSkeleton("d", second), StatusCode::kNotFound, second);
  REQUIRE(Same(Require(store->GetSkeleton("d", first)), SampleSkeleton("human")));
}

core::Model Extended(const core::Model& model, const NewClip& clip) {
  return Require(core::ExtendModel(
      model, {{clip.record.id, clip.record.label, clip.states, clip.record.subject}},
      core::Serially));
}

void TestModels(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_ERROR(store->ReadModel("d", core::Serially), StatusCode::kNotFound, "d");
  REQUIRE_ERROR(store->GetModel("d", 1), StatusCode::kNotFound, "1");
  REQUIRE_ERROR(store->ReadModel(kUnknown, core::Serially), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ListModels(kUnknown, 0, 10), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->DropModel(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->FindModelGap(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE(Require(store->ListModels("d", 0, 10)).empty());
  REQUIRE_OK(store->DropModel("d"));

  const std::vector<NewClip> clips{SampleClip("d", "walk", 1), SampleClip("d", "run", 2)};
  for (const NewClip& clip : clips) REQUIRE_OK(store->AddClip(clip));
  const core::Model model = SampleModel(clips);  // not in order of id
  REQUIRE_ERROR(store->PutModel(kUnknown, model), StatusCode::kNotFound, kUnknown);
  storage::ModelRecord first = Require(store->PutModel("d", model));
  REQUIRE(first.database == "d");
  REQUIRE(first.version == 1);
  REQUIRE(first.current);
  REQUIRE(first.create_time_us == kPutTime);
  REQUIRE(first.build_seconds == 0.25);
  REQUIRE(first.frame_count == 120);
  REQUIRE(first.clip_count == 2);
  REQUIRE(first.dimension_count == 18);
  REQUIRE(static_cast<int>(first.nodes_per_layer.size()) == model.layer_count());
  REQUIRE(first.nodes_per_layer.back() == model.tree().node_count(model.layer_count()));
  REQUIRE(model.layer_count() > 2);
  REQUIRE(Same(Require(store->GetModel("d", 1)), first));
  REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));

  SECTION("the next model takes the place of the last") {
    REQUIRE_OK(store->AddClip(SampleClip("d", "jump", 3)));
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));
    const core::Model next = SampleModel({clips[0], SampleClip("d", "jump", 3)});
    const auto second = Require(store->PutModel("d", next));
    REQUIRE(second.version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), next));
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    const auto listed = Require(store->ListModels("d", 0, 10));
    REQUIRE(listed.size() == 2);
    REQUIRE(Same(listed[0], second));
    REQUIRE(Same(listed[1], first));
    REQUIRE(Require(store->ListModels("d", 0, 1)).at(0).version == 2);
    REQUIRE(Require(store->ListModels("d", 2, 10)).at(0).version == 1);
    REQUIRE(Require(store->ListModels("d", 1, 10)).empty());
  }
  SECTION("a deleted clip stays in the model, and nowhere else") {
    REQUIRE(Require(store->FindModelGap("d")).empty());
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE(Require(store->FindModelGap("d")).removed == 1);
    REQUIRE(Require(store->FindModelGap("d")).missing.empty());
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));
    REQUIRE_ERROR(store->ReadClipStates("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run"});
    // Another clip of that name is not the one in the model.
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk", 9))).id == "walk");
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));
    REQUIRE(Require(store->FindModelGap("d")).removed == 1);
    REQUIRE(Require(store->FindModelGap("d")).missing == std::vector<std::string>{"walk"});
    const core::Model next = SampleModel({clips[1], SampleClip("d", "walk", 9)});
    REQUIRE(Require(store->PutModel("d", next)).version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), next));
  }
  SECTION("a model of a clip that was deleted or replaced is refused") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_ERROR(store->PutModel("d", model), StatusCode::kNotFound, "walk");
    REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 9)));
    REQUIRE_ERROR(store->PutModel("d", model), StatusCode::kNotFound, "walk");
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));
    REQUIRE(Require(store->ListModels("d", 0, 10)).size() == 1);
  }
  SECTION("a clip that came back is the same clip") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->AddClip(clips[0]));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), model));
  }
  SECTION("an extended model is kept, with the build that it extends") {
    const NewClip jump = SampleClip("d", "jump", 3);
    const NewClip hop = SampleClip("d", "hop", 4);
    const core::Model extended = Extended(model, jump);
    REQUIRE_ERROR(store->PutExtension("d", extended, 0.25), StatusCode::kNotFound, "jump");
    REQUIRE_OK(store->AddClip(jump));
    REQUIRE_ERROR(store->PutExtension(kUnknown, extended, 0.25), StatusCode::kNotFound, kUnknown);
    const auto second = Require(store->PutExtension("d", extended, 0.25));
    REQUIRE(second.version == 2);
    REQUIRE(second.current);
    REQUIRE(second.clip_count == 3);
    REQUIRE(second.added_clip_count == 1);
    REQUIRE(second.added_frame_count == jump.record.frame_count);
    REQUIRE(second.stale_share == 0.25);
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), extended));
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    // It is no extension of itself, nor of a build that it does not know.
    REQUIRE_ERROR(store->PutExtension("d", extended, 0), StatusCode::kFailedPrecondition, "d");

    REQUIRE_OK(store->AddClip(hop));
    REQUIRE_ERROR(store->PutExtension("d", Extended(model, hop), 0),
                  StatusCode::kFailedPrecondition, "d");
    const core::Model again = Extended(extended, hop);
    REQUIRE(Require(store->FindModelGap("d")).missing == std::vector<std::string>{"hop"});
    const auto third = Require(store->PutExtension("d", again, 0.5));
    REQUIRE(Require(store->FindModelGap("d")).empty());
    REQUIRE(third.added_clip_count == 2);
    const core::Model read = Require(store->ReadModel("d", core::Serially));
    REQUIRE(read.clips().size() == 4);
    REQUIRE(read.states() == again.states());
    REQUIRE(read.tree().frame_order() == again.tree().frame_order());

    // A clip of the build and an added one are deleted: both stay in the model.
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->DeleteClip("d", "hop"));
    REQUIRE(Require(store->ReadModel("d", core::Serially)).clips().size() == 4);
    const core::Model next = SampleModel({clips[1], jump});
    REQUIRE(Require(store->PutModel("d", next)).version == 4);
    REQUIRE(Same(Require(store->ReadModel("d", core::Serially)), next));
    REQUIRE(Require(store->GetModel("d", 4)).added_clip_count == 0);
    REQUIRE(Require(store->ListModels("d", 0, 10)).size() == 4);
  }
  SECTION("only a current model can be extended") {
    const NewClip jump = SampleClip("d", "jump", 3);
    REQUIRE_OK(store->AddClip(jump));
    REQUIRE_OK(store->DropModel("d"));
    REQUIRE(Require(store->FindModelGap("d")).missing ==
            std::vector<std::string>{"jump", "run", "walk"});
    REQUIRE_ERROR(store->PutExtension("d", Extended(model, jump), 0),
                  StatusCode::kFailedPrecondition, "d");
  }
  SECTION("a dropped model is gone, its record stays, versions go on") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->DeleteClip("d", "run"));
    REQUIRE_OK(store->DropModel("d"));
    REQUIRE_ERROR(store->ReadModel("d", core::Serially), StatusCode::kNotFound, "d");
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    for (const NewClip& clip : clips) REQUIRE_OK(store->AddClip(clip));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
  }
}

void TestOperations(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  REQUIRE_ERROR(store->GetOperation(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->PutOperation(SampleOperation(kUnknown, "x")), StatusCode::kNotFound,
                kUnknown);
  REQUIRE_ERROR(store->ListOperations(kUnknown, "", 10), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ListOperations("", kUnknown, 10), StatusCode::kNotFound, kUnknown);

  // Order is that of creation, whatever ids and times say.
  for (const char* id : {"m", "z", "a", "k"}) {
    REQUIRE_OK(store->PutOperation(SampleOperation(*id == 'k' ? "e" : "d", id)));
  }
  auto changed = SampleOperation("d", "z");
  changed.state = storage::OperationState::kFailed;
  changed.progress = 0.5;
  changed.stage = "tree, layer 3";
  changed.model_version = 4;
  changed.error_code = 8;
  changed.error_message = "disk full";
  changed.update_time_us += 10;
  REQUIRE_OK(store->PutOperation(changed));
  REQUIRE(Same(Require(store->GetOperation("z")), changed));
  REQUIRE(Same(Require(store->GetOperation("m")), SampleOperation("d", "m")));

  const auto ids = [&](const std::string& database, const std::string& before, int limit) {
    std::string joined;
    for (const auto& record : Require(store->ListOperations(database, before, limit))) {
      joined += record.id;
    }
    return joined;
  };
  REQUIRE(ids("", "", 10) == "kazm");
  REQUIRE(ids("", "", 2) == "ka");
  REQUIRE(ids("", "a", 10) == "zm");
  REQUIRE(ids("", "m", 10).empty());
  REQUIRE(ids("d", "", 10) == "azm");
  REQUIRE(ids("d", "z", 10) == "m");
  REQUIRE(ids("e", "", 10) == "k");
  REQUIRE(Same(Require(store->ListOperations("d", "a", 1)).at(0), changed));
}

}  // namespace

void TestMotionStore(const std::function<std::unique_ptr<StoreUnderTest>()>& make) {
  const auto store = make();
  SECTION("databases are kept") { TestDatabases(*store); }
  SECTION("a database is deleted with all that it holds") { TestDeleteDatabaseWithAll(*store); }
  SECTION("clips are kept") { TestClips(*store); }
  SECTION("the first clip may bring the marker set") { TestMarkerSetOfFirstClip(*store); }
  SECTION("alike skeletons are stored once") { TestSkeletons(*store); }
  SECTION("models are kept") { TestModels(*store); }
  SECTION("operations are kept, newest first") { TestOperations(*store); }
  SECTION("tokens are kept") { TestTokens(*store); }
  SECTION("changes are recorded, newest first") { TestAudit(*store); }
}

}  // namespace motiondb::tests
