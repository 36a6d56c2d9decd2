#include "tests/storage/conformance/annotation_conformance.h"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/storage/conformance/annotation_samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::EditRecord;
using storage::SegmentRecord;
using Changes = std::vector<storage::Change>;

}  // namespace

void TestSegments(StoreUnderTest& store) {
  MakeClips(store);
  const SegmentRecord label = Get(store, storage::kLabelSegment);
  CHECK(label.track == "action");
  CHECK(label.label == "walk");
  CHECK(label.start_seconds == 0);
  CHECK_FALSE(label.end_seconds);
  CHECK(label.source == storage::SegmentSource::kImport);
  CHECK(label.author == "tokens/importer");
  CHECK(label.revision == 1);
  CHECK(label.create_time_us == SampleClip("d", "walk", 1).record.create_time_us);

  // The label gives way to a segment that does not cover the clip, but not to one that does.
  const auto covering = Edit(store, {Create("c", "all", 0, std::nullopt)}).status();
  REQUIRE_ERROR(covering, StatusCode::kFailedPrecondition, "'label' ('walk')");
  REQUIRE(ReasonOf(covering) == "SEGMENTS_OVERLAP");
  const EditRecord edit = Require(Edit(store, {Create("b", "hop", 0.5, 0.75)}));
  REQUIRE(Ids(store) == "b ");
  REQUIRE(LabelOfWalk(store).empty());
  REQUIRE(edit.objects.size() == 3);  // the label, the new segment, and the label of the clip
  const SegmentRecord b = Get(store, "b");
  CHECK(Describe(b) ==
        "walk/b action 'hop' 0.5 to 0.75 source 1 confidence 1 r3 by 'tokens/me' "
        "t1700000000000099 t1700000000000099");
  CHECK(b.revision == edit.id);

  REQUIRE(ReasonOf(Edit(store, {Create("x", "l", 0.7, 1)}).status()) == "SEGMENTS_OVERLAP");
  REQUIRE_OK(Edit(store, {Create("x", "l", 0.7, 1, "hands")}));
  REQUIRE_OK(Edit(store, {Create("c", "step", 0.75, 1), Create("a", "stand", 0, 0.5)}));
  REQUIRE(Ids(store) == "a b c x ");
  REQUIRE_ERROR(Edit(store, {Create("a", "again", 1.1, 1.2)}), StatusCode::kAlreadyExists, "'a'");
  REQUIRE_ERROR(store->annotations().GetSegment("d", "walk", kUnknown), StatusCode::kNotFound,
                kUnknown);
  REQUIRE_ERROR(store->annotations().GetSegment("d", "run", "a"), StatusCode::kNotFound, "'a'");
  REQUIRE_ERROR(store->annotations().ListSegments("d", kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->annotations().ListSegments(kUnknown, "walk"), StatusCode::kNotFound,
                kUnknown);

  // A chosen id is new.
  const EditRecord chosen =
      Require(Edit(store, {Create("", "p", 0, 0.1, "p"), Create("", "q", 0.2, 0.3, "p")}));
  std::set<std::string> ids;
  for (const auto& object : chosen.objects) ids.insert(std::get<SegmentRecord>(*object.after).id);
  REQUIRE(ids.size() == 2);

  // Times: a frame is 20 ms.
  auto move = ChangeOf("c");
  for (const double end : {1.195, 1.2, 1.209}) {
    move.end_seconds = end;
    REQUIRE_OK(Edit(store, {move}));
    CHECK_FALSE(Get(store, "c").end_seconds);
    move.end_seconds = 1.0;
    REQUIRE_OK(Edit(store, {move}));
  }
  for (const double end : {1.22, 0.75, 0.7, -1.0}) {
    move.end_seconds = end;
    REQUIRE_ERROR(Edit(store, {move}), StatusCode::kInvalidArgument, "end_seconds");
  }
  REQUIRE_ERROR(Edit(store, {Create("y", "l", -0.1, 1, "t")}), StatusCode::kInvalidArgument,
                "start_seconds");
  REQUIRE_ERROR(Edit(store, {Create("y", "l", 1.2, std::nullopt, "t")}),
                StatusCode::kInvalidArgument, "start_seconds");
  move = ChangeOf("b");
  move.start_seconds = 0.4;
  REQUIRE(ReasonOf(Edit(store, {move}).status()) == "SEGMENTS_OVERLAP");
  move.start_seconds = 0.6;
  move.label = "jump";
  move.source = storage::SegmentSource::kSuggestion;
  move.confidence = 0.5;
  REQUIRE_OK(Edit(store, {move}));
  CHECK(Get(store, "b").label == "jump");
  CHECK(Get(store, "b").confidence == 0.5);

  REQUIRE_OK(Edit(store, {Delete("a"), Delete("b"), Delete("c")}));
  REQUIRE_ERROR(Edit(store, {Delete("a")}), StatusCode::kNotFound, "'a'");
  REQUIRE_OK(Edit(store, {Create("a", "all", 0, std::nullopt)}));
  REQUIRE(LabelOfWalk(store) == "all");
}

void TestLabels(StoreUnderTest& store) {
  MakeClips(store);
  auto relabel = ChangeOfClip();
  relabel.label = "march";
  const EditRecord edit = Require(Edit(store, {relabel}));
  REQUIRE(LabelOfWalk(store) == "march");
  const SegmentRecord label = Get(store, storage::kLabelSegment);
  CHECK(label.source == storage::SegmentSource::kPerson);
  CHECK(label.author == "tokens/me");
  CHECK(label.revision == edit.id);
  CHECK(Require(store->GetClip("d", "walk")).revision == edit.id);
  CHECK(Require(store->GetClip("d", "walk")).edit_time_us == kPutTime);

  // Without a label; then a new one.
  relabel.label = "";
  REQUIRE_OK(Edit(store, {relabel}));
  REQUIRE(Ids(store).empty());
  REQUIRE(LabelOfWalk(store).empty());
  REQUIRE(Require(Edit(store, {relabel})).id == 0);
  relabel.label = "stroll";
  REQUIRE_OK(Edit(store, {relabel}));
  REQUIRE(Get(store, storage::kLabelSegment).label == "stroll");

  // A change of the segment changes the label of the clip, and its revision.
  auto change = ChangeOf(storage::kLabelSegment);
  change.label = "pace";
  const EditRecord paced = Require(Edit(store, {change}));
  REQUIRE(LabelOfWalk(store) == "pace");
  REQUIRE(Require(store->GetClip("d", "walk")).revision == paced.id);

  REQUIRE_OK(Edit(store, {Create("a", "step", 0, 1)}));
  relabel.label = "other";
  const auto refused = Edit(store, {relabel}).status();
  REQUIRE_ERROR(refused, StatusCode::kFailedPrecondition, "'walk'");
  REQUIRE(ReasonOf(refused) == "CLIP_HAS_SEGMENTS");
}

void TestSegmentsOfNewClips(StoreUnderTest& store) {
  MakeClips(store);
  auto clip = SampleClip("d", "walk", 3);
  clip.record.title = "A title";
  clip.record.tags = {"a", "b"};
  clip.record.fields = {
      {"n", 1.5}, {"s", std::string("x")}, {"f", true}, {"t", storage::FieldTime{7}}};
  clip.segments.resize(2);
  clip.segments[0].label = "step";
  clip.segments[0].track = "feet";
  clip.segments[0].end_seconds = 1.2;
  clip.segments[1].label = "wave";
  clip.segments[1].track = "hands";
  clip.segments[1].id = "w";
  clip.segments[1].start_seconds = 0.5;
  const std::int64_t before = Require(store->annotations().Revision("d"));
  SECTION("are stored with its label") {
    const auto added = Require(store->AddClip(clip));
    REQUIRE(added.id == "walk-2");
    REQUIRE(added.label == "walk");
    REQUIRE(added.revision == before + 1);
    REQUIRE(Describe(added) == Describe(Require(store->GetClip("d", "walk-2"))));
    REQUIRE(added.fields == clip.record.fields);
    const auto segments = Require(store->annotations().ListSegments("d", "walk-2"));
    REQUIRE(segments.size() == 3);
    REQUIRE(segments[0].id == storage::kLabelSegment);
    REQUIRE(segments[1].label == "step");
    REQUIRE_FALSE(segments[1].end_seconds);
    REQUIRE(segments[2].id == "w");
    for (const auto& segment : segments) REQUIRE(segment.revision == added.revision);
  }
  SECTION("replace its label on the track of labels") {
    clip.segments[0].track = "action";
    clip.segments[0].end_seconds = 0.5;
    REQUIRE(Require(store->AddClip(clip)).label.empty());
    REQUIRE(Require(store->annotations().ListSegments("d", "walk-2")).size() == 2);
  }
  SECTION("there is none without a label") {
    clip.record.label.clear();
    clip.segments.clear();
    REQUIRE(Require(store->AddClip(clip)).label.empty());
    REQUIRE(Ids(store, "walk-2").empty());
  }
  SECTION("are checked") {
    clip.segments[1].track = "feet";
    REQUIRE(ReasonOf(store->AddClip(clip).status()) == "SEGMENTS_OVERLAP");
    clip.segments[1].start_seconds = 7;
    REQUIRE_ERROR(store->AddClip(clip), StatusCode::kInvalidArgument, "start_seconds");
    clip.segments = {clip.segments[0], clip.segments[0]};
    clip.segments[0].id = clip.segments[1].id = "same";
    clip.segments[1].track = "other";
    REQUIRE_ERROR(store->AddClip(clip), StatusCode::kAlreadyExists, "'same'");
    REQUIRE_ERROR(store->GetClip("d", "walk-2"), StatusCode::kNotFound, "walk-2");
    REQUIRE(Require(store->annotations().Revision("d")) == before);
  }
}

void TestEdits(StoreUnderTest& store) {
  MakeClips(store);
  auto& edits = store->annotations();
  REQUIRE(Require(edits.ListEdits("d", "", 0, 10)).empty());
  auto clip = ChangeOfClip();
  clip.title = "Title";
  clip.description = "Text";
  clip.subject = "bob";
  clip.tags = {{"b", "a", "b"}};
  clip.fields = storage::Fields{{"x", 1.0}, {"y", true}};
  clip.field = {{"x", std::nullopt}, {"z", std::string("w")}};
  const EditRecord edit = Require(Edit(store, {clip, Create("a", "l", 0, 1, "t")}));
  const auto stored = Require(store->GetClip("d", "walk"));
  REQUIRE(Describe(stored) ==
          "walk label 'walk' subject 'bob' title 'Title' description 'Text' "
          "tags [a b] y=yes z='w' r3 t1700000000000099");
  REQUIRE(edit.id == 3);
  REQUIRE(edit.id == Require(store->annotations().Revision("d")));
  REQUIRE(edit.author == "tokens/me");
  REQUIRE(edit.time_us == kPutTime);
  REQUIRE(edit.objects.size() == 2);
  REQUIRE(Describe(std::get<storage::ClipRecord>(*edit.objects[0].after)) == Describe(stored));
  REQUIRE(std::get<storage::ClipRecord>(*edit.objects[0].before).title.empty());
  REQUIRE_FALSE(edit.objects[1].before);

  // Nothing changes again.
  REQUIRE(Require(Edit(store, {clip})).id == 0);
  REQUIRE(Require(Edit(store, {})).id == 0);
  REQUIRE(Require(Edit(store, {Create("b", "l", 1, 1.1, "t"), Delete("b")})).id == 0);
  // Then the audit log has no entry either: the caller decides whether to write one.
  const storage::AuditRecord unused{.time_us = kPutTime, .method = "Edit"};
  REQUIRE(Require(store->annotations().Edit("d", {}, "me", {&unused})).id == 0);
  REQUIRE(Require(store->access().ListAuditRecords(0, 10)).empty());
  REQUIRE(Require(store->annotations().Revision("d")) == 3);
  REQUIRE(Require(store->annotations().ListEdits("d", "", 0, 10)).size() == 1);

  // All or nothing; errors name the change.
  clip.title = "Other";
  REQUIRE_ERROR(Edit(store, {clip, Delete(kUnknown)}), StatusCode::kNotFound, "changes[1]: ");
  REQUIRE(Require(store->GetClip("d", "walk")).title == "Title");
  REQUIRE_ERROR(Edit(store, {ChangeOfClip(kUnknown)}), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->annotations().Edit(kUnknown, Changes{clip}, "me"), StatusCode::kNotFound,
                kUnknown);

  // Etags.
  clip.revision = 1;
  REQUIRE_ERROR(Edit(store, {clip}), StatusCode::kAborted, "clip 'walk'");
  clip.revision = stored.revision;
  REQUIRE_OK(Edit(store, {clip}));
  REQUIRE_ERROR(Edit(store, {Delete("a", 1)}), StatusCode::kAborted, "segment 'a'");
  auto change = ChangeOf("a");
  change.revision = 3;
  change.confidence = 0.25;
  // In one edit, the revision is the one before the edit.
  REQUIRE_OK(Edit(store, {change, Delete("a", 3)}));

  // The history, newest first.
  auto run = ChangeOfClip("run");
  run.title = "Run";
  const storage::AuditRecord audit{.method = "Edit"};
  REQUIRE_OK(store->annotations().Edit("d", Changes{run}, "you", {.audit = &audit}));
  REQUIRE(Require(store->access().ListAuditRecords(0, 10)).size() == 1);
  const auto ids = [&](const std::string& of, std::int64_t before, int limit) {
    std::string text;
    for (const auto& one : Require(store->annotations().ListEdits("d", of, before, limit))) {
      text += std::to_string(one.id) + one.author + " ";
    }
    return text;
  };
  REQUIRE(ids("", 0, 10) == "6you 5tokens/me 4tokens/me 3tokens/me ");
  REQUIRE(ids("", 5, 1) == "4tokens/me ");
  REQUIRE(ids("run", 0, 10) == "6you ");
  REQUIRE(ids("wal", 0, 10).empty());
  const auto listed = Require(store->annotations().ListEdits("d", "walk", 0, 10));
  REQUIRE(listed.size() == 3);
  REQUIRE(std::get<storage::ClipRecord>(*listed[2].objects[0].after).fields == stored.fields);
  REQUIRE(std::get<storage::ClipRecord>(*listed[2].objects[0].after).database == "d");
  REQUIRE(Describe(std::get<SegmentRecord>(*listed[2].objects[1].after)) ==
          Describe(std::get<SegmentRecord>(*edit.objects[1].after)));
  REQUIRE_FALSE(listed[0].objects[0].after);
}

void TestUndo(StoreUnderTest& store) {
  MakeClips(store);
  const auto undo = [&](std::int64_t edit) {
    return store->annotations().UndoEdit("d", edit, "tokens/undo");
  };
  const std::string original = Require(store->GetClip("d", "walk")).label;
  const EditRecord split =
      Require(Edit(store, {Create("a", "l", 0, 0.5), Create("b", "m", 0.5, 1)}));
  const EditRecord undone = Require(undo(split.id));
  REQUIRE(undone.author == "tokens/undo");
  REQUIRE(undone.id == split.id + 1);
  REQUIRE(Ids(store) == "label ");
  REQUIRE(LabelOfWalk(store) == original);
  REQUIRE(Get(store, storage::kLabelSegment).revision == undone.id);
  REQUIRE_ERROR(undo(split.id), StatusCode::kAborted, "'walk'");
  REQUIRE_OK(undo(undone.id));
  REQUIRE(Ids(store) == "a b ");

  // Edits are undone one after another, the last one first.
  auto title = ChangeOfClip();
  title.title = "1";
  const std::int64_t first = Require(Edit(store, {title})).id;
  title.title = "2";
  const std::int64_t second = Require(Edit(store, {title})).id;
  REQUIRE_ERROR(undo(first), StatusCode::kAborted, "clip 'walk'");
  REQUIRE_OK(undo(second));
  REQUIRE_OK(undo(first));
  REQUIRE(Require(store->GetClip("d", "walk")).title.empty());

  // A restored segment does not overlap a new one.
  const std::int64_t deletion = Require(Edit(store, {Delete("a")})).id;
  REQUIRE_OK(Edit(store, {Create("c", "n", 0.25, 0.5)}));
  REQUIRE(ReasonOf(undo(deletion).status()) == "SEGMENTS_OVERLAP");
  REQUIRE_OK(Edit(store, {Delete("c")}));
  REQUIRE_OK(undo(deletion));
  REQUIRE(Ids(store) == "a b ");

  REQUIRE_ERROR(undo(99), StatusCode::kNotFound, "99");
  REQUIRE_ERROR(store->annotations().UndoEdit(kUnknown, 1, ""), StatusCode::kNotFound, kUnknown);
  const std::int64_t last = Require(Edit(store, {Delete("a")})).id;
  REQUIRE_OK(store->DeleteClip("d", "walk"));
  REQUIRE_ERROR(undo(last), StatusCode::kAborted, "deleted");
}

}  // namespace motiondb::tests
