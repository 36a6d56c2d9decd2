// The models of InMemoryMotionStore.
#include <algorithm>
#include <cstddef>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "tests/storage/conformance/in_memory_motion_store.h"

namespace motiondb::tests {

using storage::ModelTerms;

bool InMemoryMotionStore::IsOf(const storage::NewClip& stored, const core::Model& model,
                               const core::ModelClip& clip) {
  return stored.record.id == clip.id && stored.record.frame_count == clip.frame_count &&
         stored.record.leg_length_m == clip.leg_length_m &&
         stored.states.root_path ==
             model.root_path().middleRows(clip.first_frame, clip.frame_count);
}

bool InMemoryMotionStore::Holds(const Database& in, const core::Model& model,
                                const core::ModelClip& clip) {
  const auto stored = in.clips.find(clip.id);
  return stored != in.clips.end() && IsOf(stored->second, model, clip);
}

absl::StatusOr<storage::ModelRecord> InMemoryMotionStore::Put(Database& in,
                                                              const core::Model& model, int first) {
  for (const core::ModelClip& clip : std::span(model.clips()).subspan(first)) {
    const bool was_deleted = first == 0 && std::ranges::any_of(in.deleted, [&](const auto& other) {
                               return IsOf(other, model, clip);
                             });
    if (!was_deleted && !Holds(in, model, clip)) {
      return core::NotFound("the model's clip '{}' is no longer stored", clip.id);
    }
  }
  if (first == 0) {
    in.replaced.clear();
    std::erase_if(in.deleted, [&](const storage::NewClip& other) {
      return std::ranges::none_of(model.clips(),
                                  [&](const auto& clip) { return IsOf(other, model, clip); });
    });
  }
  if (!in.models.empty()) in.models.back().current = false;
  storage::ModelRecord record;
  record.database = in.record.name;
  record.version = static_cast<std::int32_t>(in.models.size()) + 1;
  record.current = true;
  record.create_time_us = put_time_us_;
  record.build_seconds = model.build_seconds();
  record.frame_count = model.frame_count();
  record.clip_count = static_cast<std::int32_t>(model.clips().size());
  record.dimension_count = static_cast<std::int32_t>(model.states().cols());
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    record.nodes_per_layer.push_back(model.tree().node_count(layer));
  }
  in.model = model;
  in.model_revision = ++in.revision;
  return in.models.emplace_back(std::move(record));
}

absl::StatusOr<storage::ModelRecord> InMemoryMotionStore::PutModel(const std::string& database,
                                                                   const core::Model& model,
                                                                   const ModelTerms& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  MOTIONDB_RETURN_IF_ERROR(CheckTerms(*in, terms));
  auto record = Put(*in, model, 0);
  if (record.ok()) in->built_version = record->version;
  return record;
}

absl::StatusOr<storage::ModelRecord> InMemoryMotionStore::PutExtension(const std::string& database,
                                                                       const core::Model& model,
                                                                       double drift_fraction,
                                                                       const ModelTerms& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  MOTIONDB_RETURN_IF_ERROR(CheckTerms(*in, terms));
  const auto same = [](const core::ModelClip& a, const core::ModelClip& b) {
    return a.id == b.id && a.frame_count == b.frame_count;
  };
  if (!in->model || in->model->clips().size() >= model.clips().size() ||
      !std::equal(in->model->clips().begin(), in->model->clips().end(), model.clips().begin(),
                  same)) {
    return core::FailedPrecondition("not an extension of the current model of '{}'", database);
  }
  const auto had = static_cast<int>(in->model->clips().size());
  MOTIONDB_RETURN_IF_ERROR(Put(*in, model, had).status());
  storage::ModelRecord& record = in->models.back();
  record.added_clip_count = static_cast<int>(model.clips().size()) - model.built_clip_count();
  record.added_frame_count = model.frame_count() - model.built_frame_count();
  record.drift_fraction = drift_fraction;
  return record;
}

absl::StatusOr<core::Model> InMemoryMotionStore::ReadModel(const std::string& database,
                                                           const core::ParallelFor&) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  if (!in->model) return core::NotFound("database '{}' has no model", database);
  return *in->model;
}

absl::StatusOr<core::Model> InMemoryMotionStore::ReadExtension(const std::string& database,
                                                               std::int32_t base_version,
                                                               const core::Model& base,
                                                               const core::ParallelFor&) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  if (!in->model) return core::NotFound("database '{}' has no model", database);
  if (base_version < in->built_version || base.clips().size() > in->model->clips().size()) {
    return core::FailedPrecondition("the current model does not extend model {}", base_version);
  }
  return *in->model;
}

absl::StatusOr<storage::ModelStaleness> InMemoryMotionStore::FindModelStaleness(
    const std::string& database) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  storage::ModelStaleness staleness;
  std::set<std::string> known;
  for (const core::ModelClip& clip :
       in->model ? in->model->clips() : std::vector<core::ModelClip>()) {
    if (in->replaced.contains(clip.id)) {
      ++staleness.removed;
      ++staleness.outdated;
    } else if (Holds(*in, *in->model, clip)) {
      known.insert(clip.id);
      const storage::ClipRecord& record = in->clips.at(clip.id).record;
      staleness.outdated += record.representation_version != core::kRepresentationVersion;
    } else {
      ++staleness.removed;
    }
  }
  for (const auto& [id, clip] : in->clips) {
    const bool is_current = clip.record.representation_version == core::kRepresentationVersion;
    if (is_current && !known.contains(id)) staleness.missing.push_back(id);
    staleness.to_derive += clip.record.tried_version < core::kRepresentationVersion;
  }
  return staleness;
}

absl::StatusOr<storage::ModelRecord> InMemoryMotionStore::GetModel(const std::string& database,
                                                                   int version) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  if (version < 1 || version > static_cast<int>(in->models.size())) {
    return core::NotFound("database '{}' has no model {}", database, version);
  }
  return in->models[static_cast<std::size_t>(version) - 1];
}

absl::StatusOr<std::vector<storage::ModelRecord>> InMemoryMotionStore::ListModels(
    const std::string& database, int before, int limit) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  std::vector<storage::ModelRecord> records;
  for (auto it = in->models.rbegin(); it != in->models.rend(); ++it) {
    if (static_cast<int>(records.size()) == limit) break;
    if (before == 0 || it->version < before) records.push_back(*it);
  }
  return records;
}

absl::Status InMemoryMotionStore::DropModel(const std::string& database, const ModelTerms& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  MOTIONDB_RETURN_IF_ERROR(CheckTerms(*in, terms));
  if (in->model) {
    in->models.back().current = false;
    in->model_revision = ++in->revision;
  }
  in->model.reset();
  in->deleted.clear();
  return absl::OkStatus();
}

absl::Status InMemoryMotionStore::CheckTerms(const Database& in, const ModelTerms& terms) {
  if (terms.fence != in.last_fence) return absl::AbortedError("the build lease has ended");
  const int current = in.model ? static_cast<int>(in.models.size()) : 0;
  if (terms.base_version.value_or(current) == current) return absl::OkStatus();
  return absl::AbortedError(fmt::format("the current model is {}", current));
}

absl::StatusOr<std::int64_t> InMemoryMotionStore::AcquireBuildLease(
    const std::string& database, const std::string& holder, std::chrono::milliseconds duration) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  const std::int64_t now_us = LeaseTimeUs();
  if (!in->lease_holder.empty() && in->lease_holder != holder && in->lease_expire_us > now_us) {
    return absl::AbortedError(fmt::format("'{}' has the build lease", in->lease_holder));
  }
  in->lease_holder = holder;
  in->lease_expire_us = now_us + std::chrono::microseconds(duration).count();
  return in->last_fence = ++last_fence_;
}

absl::Status InMemoryMotionStore::RenewBuildLease(const std::string& database, std::int64_t fence,
                                                  std::chrono::milliseconds duration) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  if (in->last_fence != fence || in->lease_holder.empty()) {
    return absl::AbortedError("the build lease has ended");
  }
  in->lease_expire_us = LeaseTimeUs() + std::chrono::microseconds(duration).count();
  return absl::OkStatus();
}

absl::Status InMemoryMotionStore::ReleaseBuildLease(const std::string& database,
                                                    std::int64_t fence) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  if (in->last_fence == fence) in->lease_holder.clear();
  return absl::OkStatus();
}

absl::Status InMemoryMotionStore::PurgeDeletedClips(const std::string& database,
                                                    const core::Cancelled&) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  std::erase_if(in->deleted, [&](const storage::NewClip& other) {
    return !in->model || std::ranges::none_of(in->model->clips(), [&](const auto& clip) {
      return IsOf(other, *in->model, clip);
    });
  });
  return absl::OkStatus();
}

}  // namespace motiondb::tests
