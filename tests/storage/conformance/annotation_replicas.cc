// Replicas of a database that follow its changes.
#include <map>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "core/model/model.h"
#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using State = std::map<std::string, std::string>;  // object to description

// The present state of a database.
State PresentState(StoreUnderTest& store) {
  State state;
  for (const auto& clip : Require(store->ListClips("d", {}))) {
    state[clip.id + "/"] = Describe(clip);
    for (const auto& segment : Require(store->annotations().ListSegments("d", clip.id))) {
      state[clip.id + "/" + segment.id] = Describe(segment);
    }
  }
  const auto models = Require(store->ListModels("d", 0, 1));
  if (!models.empty() && models[0].current) state["model"] = std::to_string(models[0].version);
  return state;
}

// A copy that applies changes.
struct Replica {
  State state;
  std::int64_t revision = 0;
  std::int64_t begun = 0;

  void Apply(const storage::ChangeRecord& record) {
    REQUIRE(record.revision >= revision);
    revision = record.revision;
    if (const auto* const clip = std::get_if<storage::ClipPut>(&record.change)) {
      REQUIRE(clip->clip.revision == revision);
      state[clip->clip.id + "/"] = Describe(clip->clip);
    } else if (const auto* const put = std::get_if<storage::SegmentPut>(&record.change)) {
      REQUIRE(put->segment.revision == revision);
      state[put->segment.clip + "/" + put->segment.id] = Describe(put->segment);
    } else if (const auto* const model = std::get_if<storage::ModelPut>(&record.change)) {
      state.erase("model");
      if (model->version != 0) state["model"] = std::to_string(model->version);
    } else {
      const auto& deleted = std::get<storage::Deleted>(record.change);
      const std::string name = deleted.clip + "/" + deleted.segment;
      std::erase_if(state, [&](const auto& entry) {
        return deleted.segment.empty() ? entry.first.starts_with(name) : entry.first == name;
      });
    }
  }
};

class Writer {
 public:
  Writer(StoreUnderTest& store, unsigned seed) : store_(store), random_(seed) {
    REQUIRE_OK(store_->CreateDatabase(SampleDatabase("d")));
  }

  int Below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

  // Changes the database; calls may fail.
  void Change() {
    const auto clips = Require(store_->ListClips("d", {}));
    const std::string id = std::string(1, static_cast<char>('a' + Below(4)));
    auto fresh = SampleClip("d", id, ++content_);
    fresh.record.create_time_us += content_;
    fresh.id_is_fixed = true;
    if (Below(3) == 0) fresh.record.label.clear();
    switch (Below(10)) {
      case 0:
      case 1:
        store_->AddClip(fresh).IgnoreError();
        return;
      case 2:
        store_->DeleteClip("d", id).IgnoreError();
        return;
      case 3:
        if (!clips.empty()) {
          store_
              ->ReplaceClip(clips[static_cast<std::size_t>(Below(static_cast<int>(clips.size())))],
                            fresh)
              .IgnoreError();
        }
        return;
      case 4:
        if (!clips.empty()) Derive(clips.front());
        return;
      case 5:
        if (Below(2) == 0) {
          REQUIRE_OK(store_->DropModel("d"));
        } else if (!clips.empty()) {
          BuildModel(clips.back());
        }
        return;
      case 6:
        if (last_edit_ != 0) store_->annotations().UndoEdit("d", last_edit_, "").IgnoreError();
        return;
      default:
        Edit(id);
    }
  }

 private:
  void Derive(const storage::ClipRecord& clip) {
    storage::DerivedClip derived{.record = clip};
    derived.record.tried_time_us += 1;
    if (Below(2) == 0) {
      const int frames = 30 + Below(40);
      derived.states = SampleStates(frames, ++content_);
      derived.record.frame_count = frames;
      derived.record.duration_seconds = frames / 50.0;
    }
    REQUIRE_OK(store_->PutDerived("d", std::vector<storage::DerivedClip>{derived}));
  }

  void BuildModel(const storage::ClipRecord& record) {
    storage::NewClip clip = SampleClip("d", record.id, 1);
    clip.record = record;
    clip.states = Require(store_->ReadClipStates("d", record.id));
    REQUIRE_OK(store_->PutModel("d", SampleModel({clip})));
  }

  void Edit(const std::string& clip) {
    std::vector<storage::Change> changes;
    for (int count = 1 + Below(2); count > 0; --count) {
      const std::string id(1, static_cast<char>('s' + Below(3)));
      if (Below(3) == 0) {
        changes.emplace_back(storage::SegmentDeletion{clip, id});
      } else if (Below(2) == 0) {
        storage::SegmentCreation creation;
        creation.segment.clip = clip;
        creation.segment.id = id;
        creation.segment.track = id;
        creation.segment.start_seconds = 0.1 * Below(5);
        creation.segment.end_seconds = creation.segment.start_seconds + 0.1;
        changes.emplace_back(creation);
      } else {
        storage::ClipChange change;
        change.clip = clip;
        change.title = std::to_string(Below(3));
        if (Below(2) == 0) change.label = id;
        changes.emplace_back(change);
      }
    }
    const auto edit = store_->annotations().Edit("d", changes, "me");
    if (edit.ok() && edit->id != 0) last_edit_ = edit->id;
  }

  StoreUnderTest& store_;
  std::mt19937 random_;
  unsigned content_ = 0;
  std::int64_t last_edit_ = 0;
};

}  // namespace

void TestReplicas(StoreUnderTest& store, unsigned seed, int steps) {
  CAPTURE(seed);
  Writer writer(store, seed);
  std::vector<Replica> replicas(1);
  for (int step = 0; step < steps; ++step) {
    CAPTURE(step);
    writer.Change();
    // Some replicas read a page; a new one begins from time to time.
    for (Replica& replica : replicas) {
      if (writer.Below(3) != 0) continue;
      const int limit = 1 + writer.Below(5);
      const auto changes =
          Require(store->annotations().Changes("d", replica.revision, limit, replica.begun));
      const std::int64_t now = Require(store->annotations().Revision("d"));
      for (const auto& change : changes) replica.Apply(change);
      if (std::ssize(changes) < limit) REQUIRE(replica.state == PresentState(store));
      if (!changes.empty()) REQUIRE(changes.back().revision <= now);
    }
    if (replicas.size() < 6 && writer.Below(10) == 0) {
      replicas.push_back({{}, 0, Require(store->annotations().Revision("d"))});
    }
  }
  const State present = PresentState(store);
  for (Replica& replica : replicas) {
    while (true) {
      const auto changes =
          Require(store->annotations().Changes("d", replica.revision, 2, replica.begun));
      if (changes.empty()) break;
      for (const auto& change : changes) replica.Apply(change);
    }
    REQUIRE(replica.state == present);
  }
}

}  // namespace motiondb::tests
