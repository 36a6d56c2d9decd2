#include <algorithm>
#include <set>
#include <vector>

#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/conformance/annotation_samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::Change;
using Changes = std::vector<Change>;

}  // namespace

void TestKeptAnnotations(StoreUnderTest& store) {
  MakeClips(store);
  auto clip = ChangeOfClip();
  clip.title = "Title";
  clip.tags = {{"a"}};
  REQUIRE_OK(
      Edit(store, {clip, Create("x", "l", 0.2, 1.1, "t"), Create("y", "m", 1.1, 1.15, "t")}));
  const auto before = Require(store->GetClip("d", "walk"));
  auto next = SampleClip("d", "walk", 7);
  next.record.label.clear();
  SECTION("by a clip that replaces it") {
    next.record.title = "New";
    const auto replaced = Require(store->ReplaceClip(before, next));
    REQUIRE(replaced.revision == before.revision + 1);
    REQUIRE(replaced.title == "New");
    REQUIRE(replaced.tags == before.tags);
    REQUIRE(replaced.label == "walk");
    REQUIRE(Ids(store) == "label x y ");
    REQUIRE(Get(store, "x").revision == before.revision);
  }
  SECTION("with a new label") {
    next.record.label = "march";
    REQUIRE(Require(store->ReplaceClip(before, next)).label == "march");
    REQUIRE(Get(store, storage::kLabelSegment).revision == before.revision + 1);
  }
  SECTION("unless the new clip has segments of its own") {
    next.segments.resize(1);
    next.segments[0].track = "t";
    next.segments[0].id = "z";
    REQUIRE_OK(store->ReplaceClip(before, next));
    REQUIRE(Ids(store) == "label z ");
  }
  SECTION("under another id") {
    next.record.id = "hop";
    REQUIRE_OK(store->ReplaceClip(before, next));
    REQUIRE(Ids(store, "hop") == "label x y ");
    REQUIRE(Require(store->annotations().GetSegment("d", "hop", "x")).clip == "hop");
  }
  SECTION("fitted to a shorter clip") {
    next.record.frame_count = 50;
    next.record.duration_seconds = 1;
    next.states = SampleStates(50, 7);
    REQUIRE_OK(store->ReplaceClip(before, next));
    REQUIRE(Ids(store) == "label x ");
    REQUIRE_FALSE(Get(store, "x").end_seconds);
  }
  SECTION("if its states are derived again") {
    storage::DerivedClip derived{.record = before};
    derived.record.title = "stale";  // the clip was edited after it was listed
    derived.record.subject = "stale";
    if (GENERATE(true, false)) {
      derived.states = SampleStates(50, 7);
      derived.record.frame_count = 50;
      derived.record.duration_seconds = 1;
    }
    const auto stored = Require(store->PutDerived("d", std::vector<storage::DerivedClip>{derived}));
    REQUIRE(stored.size() == 1);
    REQUIRE(stored[0].title == "Title");
    REQUIRE(stored[0].subject == before.subject);
    REQUIRE(stored[0].label == "walk");
    REQUIRE(stored[0].revision == before.revision + 1);
    REQUIRE(Ids(store) == (derived.states ? "label x " : "label x y "));
  }
  SECTION("not by a clip that is added after it was deleted") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE(Require(store->annotations().Revision("d")) == before.revision + 1);
    REQUIRE_ERROR(store->annotations().ListSegments("d", "walk"), StatusCode::kNotFound, "walk");
    const auto added = Require(store->AddClip(next));
    REQUIRE(added.title.empty());
    REQUIRE(Ids(store).empty());
  }
}

void TestTextSearch(StoreUnderTest& store) {
  MakeClips(store);
  auto clip = ChangeOfClip();
  clip.title = "Slow Café walk";
  clip.description = "to the river";
  clip.tags = {{"set-2", "night"}};
  REQUIRE_OK(Edit(store, {clip, Create("x", "wave left hand", 0, 1, "hands")}));
  const auto found = [&](const std::string& query) {
    std::set<std::string> ids;
    for (const auto& match : Require(store->annotations().SearchClips("d", query))) {
      ids.insert(match.clip);
    }
    std::string text;
    for (const std::string& id : ids) text += id + " ";
    return text;
  };
  CHECK(found("walk") == "run walk ");  // a label, a title
  CHECK(found("SLOW cafe") == "walk ");
  CHECK(found("\"slow cafe\"") == "walk ");
  CHECK(found("\"cafe slow\"").empty());
  CHECK(found("\"walk to\"").empty());    // two fields
  CHECK(found("\"hand walk\"").empty());  // two labels
  CHECK(found("\"night set\"").empty());  // two tags
  CHECK(found("set-2") == "walk ");
  CHECK(found("riv*") == "walk ");
  CHECK(found("riv").empty());
  CHECK(found("run.amc") == "run ");
  CHECK(found("subject") == "run walk ");
  CHECK(found("subject river") == "walk ");
  CHECK(found("left") == "walk ");
  REQUIRE_ERROR(store->annotations().SearchClips("d", "a \"b"), StatusCode::kInvalidArgument,
                "position 3");
  REQUIRE_ERROR(store->annotations().SearchClips(kUnknown, "a"), StatusCode::kNotFound, kUnknown);

  REQUIRE_OK(Edit(store, {Delete("x")}));
  CHECK(found("left").empty());
  auto derived = SampleClip("d", "walk", 9);
  derived.record.subject = "zoe";
  const auto former = Require(store->GetClip("d", "walk"));  // each use of `store` opens it again
  REQUIRE_OK(store->ReplaceClip(former, derived));
  CHECK(found("zoe cafe") == "walk ");
  REQUIRE_OK(store->DeleteClip("d", "run"));
  CHECK(found("walk") == "walk ");
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  CHECK(Require(store->annotations().SearchClips("e", "walk")).empty());
}

void TestChanges(StoreUnderTest& store) {
  MakeClips(store);
  const auto changes = [&](std::int64_t after, int limit) {
    std::string text;
    for (const auto& [revision, change] :
         Require(store->annotations().Changes("d", after, limit))) {
      text += std::to_string(revision);
      if (const auto* const clip = std::get_if<storage::ClipPut>(&change)) {
        text += "+" + clip->clip.id + " ";
      } else if (const auto* const segment = std::get_if<storage::SegmentPut>(&change)) {
        text += "+" + segment->segment.clip + "/" + segment->segment.id + " ";
      } else if (const auto* const model = std::get_if<storage::ModelPut>(&change)) {
        text += "+model" + std::to_string(model->version) + " ";
      } else {
        const auto& deleted = std::get<storage::Deleted>(change);
        text += "-" + deleted.clip + (deleted.segment.empty() ? "" : "/" + deleted.segment) + " ";
      }
    }
    return text;
  };
  REQUIRE(changes(0, 10) == "1+walk 1+walk/label 2+run 2+run/label ");
  REQUIRE(changes(0, 1) == "1+walk 1+walk/label ");
  REQUIRE(changes(0, 3) == "1+walk 1+walk/label 2+run 2+run/label ");
  REQUIRE(changes(1, 1) == "2+run 2+run/label ");
  REQUIRE(changes(2, 1).empty());
  REQUIRE_OK(Edit(store, {Create("a", "l", 0, 1)}));
  REQUIRE(changes(2, 1) == "3-walk/label 3+walk 3+walk/a ");
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "run", 2)})));
  REQUIRE(changes(3, 9) == "4+model1 ");
  REQUIRE_OK(store->DropModel("d"));
  REQUIRE(changes(3, 9) == "5+model0 ");
  REQUIRE_OK(store->DropModel("d"));
  REQUIRE_OK(store->DeleteClip("d", "walk"));
  REQUIRE(changes(1, 9) == "2+run 2+run/label 5+model0 6-walk ");
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 3)));
  REQUIRE(changes(5, 9) == "6-walk 7+walk 7+walk/label ");
  REQUIRE(Require(store->annotations().Revision("d")) == 7);
  REQUIRE_ERROR(store->annotations().Revision(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->annotations().Changes(kUnknown, 0, 1), StatusCode::kNotFound, kUnknown);
}

}  // namespace motiondb::tests
