// Random edits and undos, compared with a simple model of their effect.
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;

constexpr int kEnd = 12;  // of each clip, in tenths of a second

struct ModelSegment {
  std::string track;
  std::string label;
  int start = 0;
  int end = kEnd;

  auto operator<=>(const ModelSegment&) const = default;
};

struct ModelClip {
  std::string title;
  std::map<std::string, ModelSegment> segments;

  auto operator<=>(const ModelClip&) const = default;
};

using Model = std::map<std::string, ModelClip>;

// The state of an object as text; empty: it does not exist. A clip's includes its label.
std::string StateOf(const Model& model, const std::string& clip, const std::string& segment) {
  const ModelClip& in = model.at(clip);
  if (segment.empty()) {
    std::string label;
    for (const auto& [id, s] : in.segments) {
      if (s.track == "action" && s.start == 0 && s.end == kEnd) label = s.label;
    }
    return in.title + "|" + label;
  }
  const auto found = in.segments.find(segment);
  if (found == in.segments.end()) return "";
  const ModelSegment& s = found->second;
  return s.track + "|" + s.label + "|" + std::to_string(s.start) + "|" + std::to_string(s.end);
}

bool Overlaps(const ModelClip& clip, const std::string& id) {
  const ModelSegment& s = clip.segments.at(id);
  for (const auto& [other_id, other] : clip.segments) {
    if (other_id != id && other.track == s.track && s.start < other.end && other.start < s.end) {
      return true;
    }
  }
  return false;
}

using ObjectKey = std::pair<std::string, std::string>;  // clip, segment

// Names of all objects whose state differs.
std::set<ObjectKey> Differences(const Model& a, const Model& b) {
  std::set<ObjectKey> objects;
  for (const Model* const model : {&a, &b}) {
    for (const auto& [clip, state] : *model) {
      if (StateOf(a, clip, "") != StateOf(b, clip, "")) objects.insert({clip, ""});
      for (const auto& [id, segment] : state.segments) {
        if (StateOf(a, clip, id) != StateOf(b, clip, id)) objects.insert({clip, id});
      }
    }
  }
  return objects;
}

class RandomEdits {
 public:
  RandomEdits(StoreUnderTest& store, unsigned seed) : store_(store), random_(seed) {
    REQUIRE_OK(store_->CreateDatabase(SampleDatabase("d")));
    unsigned clip_seed = 1;
    for (const char* const id : {"p", "q"}) {
      REQUIRE_OK(store_->AddClip(SampleClip("d", id, clip_seed++)));
      model_[id].segments["label"] = {"action", "walk", 0, kEnd};
      ++revision_;
      revisions_[{id, ""}] = revisions_[{id, "label"}] = revision_;
    }
  }

  void Step() {
    if (!edits_.empty() && Chance(5)) {
      Undo();
    } else {
      Edit();
    }
    Compare();
  }

  int succeeded() const { return succeeded_; }

 private:
  int Below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool Chance(int one_in) { return Below(one_in) == 0; }
  template <typename T>
  T Pick(std::initializer_list<T> values) {
    return *(values.begin() + Below(static_cast<int>(values.size())));
  }

  // Returns a revision to pass with a change: none, the right one, or a wrong one.
  std::int64_t Seen(const ObjectKey& object) {
    if (!Chance(3)) return 0;
    const auto found = revisions_.find(object);
    if (found == revisions_.end() || Chance(3)) return 1 + Below(static_cast<int>(revision_) + 1);
    return found->second;
  }

  bool IsStale(const ObjectKey& object, std::int64_t seen) const {
    const auto found = revisions_.find(object);
    return seen != 0 && (found == revisions_.end() || found->second != seen);
  }

  // Adds a random change to `changes_` and applies it to `next`. Returns the expected code.
  StatusCode AddChange(Model& next) {
    const std::string clip = Pick({"p", "q"});
    ModelClip& in = next.at(clip);
    const std::string id = Pick({"label", "a", "b", "c"});
    const int start = Pick({0, 0, 3, 5, 8});
    const int end = Pick({3, 5, 8, kEnd, kEnd, 14});
    const std::string label = Pick({"walk", "run", "hop"});
    switch (Below(4)) {
      case 0: {
        storage::ClipChange change;
        change.clip = clip;
        change.revision = Seen({clip, ""});
        if (Chance(2)) change.title = label;
        if (Chance(2)) change.label = Chance(4) ? "" : label;
        changes_.push_back(change);
        if (IsStale({clip, ""}, change.revision)) return StatusCode::kAborted;
        if (change.title) in.title = *change.title;
        return change.label ? SetLabel(in, *change.label) : StatusCode::kOk;
      }
      case 1: {
        storage::SegmentCreation change;
        change.segment.clip = clip;
        change.segment.id = id;
        change.segment.track = Pick({"action", "action", "hands"});
        change.segment.label = label;
        change.segment.start_seconds = start / 10.0;
        if (end != kEnd || Chance(2)) change.segment.end_seconds = end / 10.0;
        changes_.push_back(change);
        if (in.segments.contains(id)) return StatusCode::kAlreadyExists;
        if (end > kEnd || start >= end) return StatusCode::kInvalidArgument;
        const ModelSegment segment{change.segment.track, label, start, end};
        const auto covering = in.segments.find("label");
        const bool covers = start == 0 && end == kEnd;
        if (!covers && covering != in.segments.end() && covering->second.track == segment.track &&
            covering->second.start == 0 && covering->second.end == kEnd) {
          in.segments.erase(covering);
        }
        in.segments[id] = segment;
        return Overlaps(in, id) ? StatusCode::kFailedPrecondition : StatusCode::kOk;
      }
      case 2: {
        storage::SegmentChange change;
        change.clip = clip;
        change.id = id;
        const bool created = !revisions_.contains({clip, id}) && in.segments.contains(id);
        change.revision = created ? 0 : Seen({clip, id});
        if (Chance(2)) change.label = label;
        if (Chance(2)) change.start_seconds = start / 10.0;
        if (Chance(2)) change.end_seconds = std::optional(end / 10.0);
        changes_.push_back(change);
        if (!in.segments.contains(id)) return StatusCode::kNotFound;
        if (IsStale({clip, id}, change.revision)) return StatusCode::kAborted;
        ModelSegment& segment = in.segments[id];
        if (change.label) segment.label = label;
        if (change.start_seconds) segment.start = start;
        if (change.end_seconds) segment.end = end;
        if (segment.end > kEnd || segment.start >= segment.end) return StatusCode::kInvalidArgument;
        return Overlaps(in, id) ? StatusCode::kFailedPrecondition : StatusCode::kOk;
      }
      default: {
        const bool created = !revisions_.contains({clip, id}) && in.segments.contains(id);
        const std::int64_t seen = created ? 0 : Seen({clip, id});
        changes_.push_back(storage::SegmentDeletion{clip, id, seen});
        if (!in.segments.contains(id)) return StatusCode::kNotFound;
        if (IsStale({clip, id}, seen)) return StatusCode::kAborted;
        in.segments.erase(id);
        return StatusCode::kOk;
      }
    }
  }

  static StatusCode SetLabel(ModelClip& clip, const std::string& label) {
    for (auto& [id, segment] : clip.segments) {
      if (segment.track != "action") continue;
      const bool covers = segment.start == 0 && segment.end == kEnd;
      if (!covers) return label.empty() ? StatusCode::kOk : StatusCode::kFailedPrecondition;
      if (label.empty()) {
        clip.segments.erase(id);
      } else {
        segment.label = label;
      }
      return StatusCode::kOk;
    }
    if (label.empty()) return StatusCode::kOk;
    if (clip.segments.contains("label")) return StatusCode::kUnknown;  // another id is chosen
    clip.segments["label"] = {"action", label, 0, kEnd};
    return StatusCode::kOk;
  }

  void Edit() {
    changes_.clear();
    Model next = model_;
    StatusCode expected = StatusCode::kOk;
    for (int count = 1 + Below(3); count > 0 && expected == StatusCode::kOk; --count) {
      expected = AddChange(next);
    }
    if (expected == StatusCode::kUnknown) return;  // the model does not know the chosen id
    Expect(store_->annotations().Edit("d", changes_, "me"), expected, next);
  }

  void Undo() {
    const auto& [id, before, after] =
        edits_[static_cast<std::size_t>(Below(static_cast<int>(edits_.size())))];
    Model next = model_;
    StatusCode expected = StatusCode::kOk;
    const auto changed = Differences(before, after);
    for (const auto& [clip, segment] : changed) {
      if (StateOf(model_, clip, segment) != StateOf(after, clip, segment)) {
        expected = StatusCode::kAborted;
      }
      if (segment.empty()) {
        next[clip].title = before.at(clip).title;
      } else if (before.at(clip).segments.contains(segment)) {
        next[clip].segments[segment] = before.at(clip).segments.at(segment);
      } else {
        next[clip].segments.erase(segment);
      }
    }
    for (const auto& [clip, segment] : changed) {
      const bool overlaps = next[clip].segments.contains(segment) && Overlaps(next[clip], segment);
      if (expected == StatusCode::kOk && overlaps) expected = StatusCode::kFailedPrecondition;
    }
    Expect(store_->annotations().UndoEdit("d", id, "me"), expected, next);
  }

  void Expect(const absl::StatusOr<storage::EditRecord>& edit, StatusCode expected,
              const Model& next) {
    INFO(edit.status().ToString());
    REQUIRE(edit.status().code() == expected);
    if (!edit.ok()) return;
    const auto changed = Differences(model_, next);
    std::set<ObjectKey> objects;
    for (const auto& object : edit->objects) {
      const auto& state = object.after ? *object.after : *object.before;
      if (const auto* const clip = std::get_if<storage::ClipRecord>(&state)) {
        objects.insert({clip->id, ""});
      } else {
        const auto& segment = std::get<storage::SegmentRecord>(state);
        objects.insert({segment.clip, segment.id});
      }
    }
    REQUIRE(objects == changed);
    REQUIRE(objects.size() == edit->objects.size());
    REQUIRE(edit->id == (changed.empty() ? 0 : revision_ + 1));
    if (changed.empty()) return;
    ++revision_;
    ++succeeded_;
    for (const auto& object : changed) {
      if (StateOf(next, object.first, object.second).empty()) {
        revisions_.erase(object);
      } else {
        revisions_[object] = revision_;
      }
    }
    edits_.emplace_back(edit->id, model_, next);
    model_ = next;
  }

  void Compare() {
    REQUIRE(Require(store_->annotations().Revision("d")) == revision_);
    Model stored;
    for (const auto& clip : Require(store_->ListClips("d", {}))) {
      ModelClip& to = stored[clip.id];
      to.title = clip.title;
      REQUIRE(clip.revision == revisions_[(ObjectKey{clip.id, ""})]);
      for (const auto& segment : Require(store_->annotations().ListSegments("d", clip.id))) {
        to.segments[segment.id] = {
            segment.track, segment.label, static_cast<int>(std::lround(segment.start_seconds * 10)),
            segment.end_seconds ? static_cast<int>(std::lround(*segment.end_seconds * 10)) : kEnd};
        REQUIRE(segment.revision == revisions_[(ObjectKey{clip.id, segment.id})]);
      }
      REQUIRE(StateOf(stored, clip.id, "") == clip.title + "|" + clip.label);
    }
    REQUIRE(stored == model_);
  }

  StoreUnderTest& store_;
  std::mt19937 random_;
  Model model_;
  std::int64_t revision_ = 0;
  std::map<ObjectKey, std::int64_t> revisions_;
  std::vector<storage::Change> changes_;
  std::vector<std::tuple<std::int64_t, Model, Model>> edits_;  // id, state before, state after
  int succeeded_ = 0;
};

}  // namespace

void TestRandomEdits(StoreUnderTest& store, unsigned seed, int steps) {
  CAPTURE(seed);
  RandomEdits edits(store, seed);
  for (int step = 0; step < steps; ++step) {
    CAPTURE(step);
    edits.Step();
  }
  CHECK(edits.succeeded() > steps / 8);
}

}  // namespace motiondb::tests
