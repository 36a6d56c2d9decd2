#include "tests/simulation/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include "core/model/model.h"

namespace motiondb::simulation {
namespace {

[[noreturn]] void Fail(const std::string& what) { World::Current().Fail(what); }

StoredModel ModelOf(const core::Model& model, std::int64_t create_time_us) {
  StoredModel stored{.create_time_us = create_time_us, .frame_count = model.frame_count()};
  for (const core::ModelClip& clip : model.clips()) stored.clips.push_back(clip.id);
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    stored.nodes_per_layer.push_back(model.tree().node_count(layer));
  }
  const auto states = model.states();
  const std::string_view bytes(reinterpret_cast<const char*>(states.data()),
                               static_cast<std::size_t>(states.size()) * sizeof(float));
  stored.states_hash = std::hash<std::string_view>()(bytes);
  return stored;
}

// Whether each content, or none, has a clip.
bool AllHave(const std::vector<const StoredClips*>& contents, const std::string& clip) {
  return std::ranges::all_of(contents, [&](const auto* clips) { return clips->contains(clip); });
}
bool NoneHas(const std::vector<const StoredClips*>& contents, const std::string& clip) {
  return std::ranges::none_of(contents, [&](const auto* clips) { return clips->contains(clip); });
}

bool AnyHas(const std::vector<const StoredClips*>& contents, const std::string& clip,
            const auto& condition) {
  return std::ranges::any_of(contents, [&](const auto* clips) {
    const auto found = clips->find(clip);
    return found != clips->end() && condition(found->second);
  });
}

}  // namespace

std::vector<const StoredClips*> DatabaseLife::Since(std::int64_t revision) const {
  auto first = std::ssize(contents) - 1;
  while (first > 0 && contents[first].revision > revision) --first;
  std::vector<const StoredClips*> since;
  for (auto i = first; i < std::ssize(contents); ++i) since.push_back(&contents[i].clips);
  return since;
}

History::History(StoreServer& server) : server_(server), store_(server, nullptr) {
  server.set_after_change([this](const StoreCall& call) { OnChange(call); });
}

DatabaseLife* History::Find(const std::string& name) {
  for (auto& [id, life] : lives_) {
    if (life.name == name && !life.is_deleted) return &life;
  }
  return nullptr;
}

DatabaseLife* History::FindByClip(const std::string& name, std::int64_t clip_create_time_us) {
  for (auto& [id, life] : lives_) {
    if (life.name != name) continue;
    for (const auto& content : life.contents) {
      for (const auto& [clip, stored] : content.clips) {
        if (stored.create_time_us == clip_create_time_us) return &life;
      }
    }
  }
  return nullptr;
}

void History::OnChange(const StoreCall& call) {
  if (call.name == "AcquireBuildLease") return;
  if (call.name == "PutOperation") return NoteOperation(call);
  ReadContents();
  if (!call.terms) return;
  if (DatabaseLife* const life = Find(call.database)) ReadModel(call, *life);
}

void History::NoteOperation(const StoreCall& call) {
  DatabaseLife* const life = Find(call.database);
  if (life == nullptr) return;
  operation_lives_.emplace(call.operation->id, life->id);
  const storage::OperationState state = call.operation->state;
  const bool is_stopped =
      state == storage::OperationState::kCancelled || state == storage::OperationState::kFailed;
  if (is_stopped) life->incomplete = World::Current().now();
}

std::int64_t History::LifeOfOperation(const std::string& operation) const {
  const auto found = operation_lives_.find(operation);
  return found == operation_lives_.end() ? 0 : found->second;
}

void History::ReadContents() {
  const auto states = *store_.ListDatabaseStates();
  for (auto& [id, life] : lives_) {
    life.is_deleted = std::ranges::find(states, id, &storage::DatabaseState::id) == states.end();
  }
  for (const storage::DatabaseState& state : states) {
    DatabaseLife& life = lives_[state.id];
    life.id = state.id;
    life.name = state.name;
    DatabaseLife::Content content{.revision = state.revision};
    const auto clips = store_.ListClips(state.name, {});
    for (const storage::ClipRecord& clip : *clips) {
      content.clips[clip.id] = {clip.create_time_us, clip.frame_count, clip.label};
    }
    if (state.revision < life.contents.back().revision) {
      Fail(fmt::format("the revision of {} went back from {} to {}", state.name,
                       life.contents.back().revision, state.revision));
    }
    if (!content.clips.empty() && store_.GetDatabase(state.name)->marker_set_text.empty()) {
      Fail(fmt::format("{} has clips, but not the markers of the first one", state.name));
    }
    if (content.clips == life.clips()) continue;
    if (state.revision == life.contents.back().revision) {
      Fail(fmt::format("the clips of {} changed without a new revision", state.name));
    }
    life.contents.push_back(std::move(content));
  }
}

void History::ReadModel(const StoreCall& call, DatabaseLife& life) {
  const auto newest = *store_.ListModels(life.name, 0, 1);
  const bool has_model = !newest.empty() && newest.front().current;
  const int version = has_model ? newest.front().version : 0;
  if (version == life.current_model) return;
  CheckTerms(call, life, std::exchange(life.current_model, version));
  const std::int64_t revision = *store_.Revision(life.name);
  if (revision <= std::exchange(life.model_revision, revision)) {
    Fail(fmt::format("model {} of {} has no new revision", version, life.name));
  }
  if (version == 0) return;
  if (!life.models.empty() && version <= life.models.rbegin()->first) {
    Fail(fmt::format("model {} of {} was stored twice", version, life.name));
  }
  life.models[version] = ModelOf(*call.model, newest.front().create_time_us);
  if (on_model_) on_model_(life);
}

void History::CheckIsFreed() {
  const auto count = server_.connection().QueryInteger(
      "SELECT (SELECT count(*) FROM clip JOIN database USING (database_key) WHERE "
      "database.deleted = 1) + (SELECT count(*) FROM model JOIN database USING (database_key) "
      "WHERE database.deleted = 1)");
  if (*count > 0) Fail("the space of a deleted database is not freed");
}

std::int64_t History::LastFence(const DatabaseLife& life) {
  storage::Statement row =
      server_.connection().Query("SELECT fence FROM build_lease WHERE database_key = ?", life.id);
  return *row.Step() ? row.Integer(0) : 0;
}

void History::CheckTerms(const StoreCall& call, const DatabaseLife& life, int replaced) {
  if (call.terms->fence >> 32 != life.id) {  // it begins with the id
    Fail(fmt::format("a builder of a deleted database has stored a model of {}", life.name));
  }
  if (const std::int64_t fence = LastFence(life); call.terms->fence < fence) {
    Fail(fmt::format("a fenced builder has stored a model of {}: its lease is {}, the last is {}",
                     life.name, call.terms->fence, fence));
  }
  if (call.terms->base_version && *call.terms->base_version != replaced) {
    Fail(fmt::format("a model of {} was computed from model {}, but replaced model {}", life.name,
                     *call.terms->base_version, replaced));
  }
}

const DatabaseLife& History::LifeOf(const std::string& what, const std::string& database,
                                    const storage::ModelRecord& record) const {
  for (const auto& [id, life] : lives_) {
    const auto stored = life.models.find(record.version);
    if (life.name != database || stored == life.models.end()) continue;
    if (stored->second.create_time_us == record.create_time_us) return life;
  }
  Fail(fmt::format("{}: model {} was never stored", what, record.version));
}

bool History::CheckServed(const std::string& what, std::int64_t id,
                          const server::ServedModel& served) {
  const auto found = lives_.find(id);
  if (found == lives_.end() || found->second.is_deleted) return false;
  const DatabaseLife& life = found->second;
  const server::Snapshot* const snapshot = served.snapshot.get();
  const storage::ModelRecord* const record = served.record();
  if (record != nullptr && (snapshot == nullptr || snapshot->is_stored())) {
    if (LifeOf(what, life.name, *record).id != id) return false;
    const StoredModel& stored = life.models.at(record->version);
    if (snapshot != nullptr && ModelOf(snapshot->model, record->create_time_us) != stored) {
      Fail(fmt::format("{}: model {} differs from the stored one", what, record->version));
    }
  }
  std::map<std::string, std::string> labels;
  const auto contents = life.Since(served.revision);
  if (snapshot != nullptr) {
    for (const core::ModelClip& clip : snapshot->model.clips()) {
      labels[clip.id] = clip.label();
      const auto has_frames = [&](const StoredClip& stored) {
        return stored.frame_count == clip.frame_count;
      };
      if (AllHave(contents, clip.id) && !AnyHas(contents, clip.id, has_frames)) {
        Fail(fmt::format("{}: another clip {} at revision {}", what, clip.id, served.revision));
      }
    }
  }
  CheckListed(what, life, served.revision, labels);
  return true;
}

void History::CheckListed(const std::string& what, const DatabaseLife& life, std::int64_t revision,
                          const std::map<std::string, std::string>& labels) const {
  const auto contents = life.Since(revision);
  for (const auto& [clip, stored] : *contents.front()) {
    if (AllHave(contents, clip) && !labels.contains(clip)) {
      Fail(fmt::format("{}: lacks clip {} at revision {}", what, clip, revision));
    }
  }
  for (const auto& [clip, label] : labels) {
    // Models may have deleted clips, but not at the revision of the deletion.
    if (revision > 0 && NoneHas(contents, clip)) {
      Fail(fmt::format("{}: has the deleted clip {} at revision {}", what, clip, revision));
    }
    const auto has_label = [&](const StoredClip& other) { return other.label == label; };
    if (revision > 0 && AllHave(contents, clip) && !AnyHas(contents, clip, has_label)) {
      Fail(fmt::format("{}: clip {} has the old label {} at revision {}", what, clip, label,
                       revision));
    }
  }
}

}  // namespace motiondb::simulation
