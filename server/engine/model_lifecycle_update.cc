// Updates of the model of a ModelLifecycle by stored clips and labels, without a build.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "server/engine/compute_model.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/work/operation_registry.h"
#include "server/engine/work/shared_loop.h"
#include "server/filter/catalog.h"
#include "storage/blob/newer_format.h"
#include "storage/clip_segments.h"

namespace motiondb::server {
namespace {

// Models of older versions have no calibration for unknown motion. Models without a metric cannot
// have one.
bool LacksCalibration(const core::Model& model) {
  return !model.metric().empty() &&
         model.recognition().unknown == core::UnknownCalibration::kNotFitted;
}

bool IsExtensible(const Snapshot& snapshot) {
  return snapshot.is_extensible && snapshot.model.tree().has_planes();
}

// Returns the stored labels and subjects of the model's clips, or nullopt if the model has them. A
// clip that is no longer stored keeps its own. O(clips + segments).
std::optional<std::vector<core::ClipLabels>> StoredLabels(const core::Model& model,
                                                          const Catalog& catalog) {
  std::vector<core::ClipLabels> labels;
  labels.reserve(model.clips().size());
  bool is_changed = false;
  for (const core::ModelClip& clip : model.clips()) {
    const CatalogClip* const stored = catalog.Find(clip.id);
    if (stored == nullptr) {
      labels.push_back({clip.labels, clip.subject});
      continue;
    }
    labels.push_back(
        {storage::LabelTracksOf(stored->segments, model.settings().frame_rate_hz, clip.frame_count),
         stored->subject});
    is_changed =
        is_changed || labels.back().labels != clip.labels || labels.back().subject != clip.subject;
  }
  if (!is_changed) return std::nullopt;
  return labels;
}

}  // namespace

absl::Status ModelLifecycle::UpdateCurrent(bool may_extend, bool is_used) {
  may_extend &= services_.options.builds();
  const auto unloaded = served().unloaded;
  const bool loads = unloaded != nullptr && (is_used || may_extend);
  if (loads) MakeRoom(BytesOfModel(*unloaded));
  absl::Status status = WithoutExceptions<absl::Status>([&] {
    if (is_shared()) {
      const absl::Status counted = database_.Recount(services_.store.annotations());
      // By its former size, a database without a model could seem empty.
      if (absl::IsUnavailable(counted)) return counted;
    }
    const SnapshotPointer current = snapshot();
    may_extend &= current != nullptr && IsExtensible(*current);
    // Without the lease, the server that has it or the next build adds the clips.
    const Lease lease = may_extend ? AcquireLease().value_or(nullptr) : HeldLease();
    return Replace([&](ServedModel served) -> absl::StatusOr<ServedModel> {
      MOTIONDB_ASSIGN_OR_RETURN(
          served, loads ? Loaded(std::move(served)) : Followed(std::move(served), false));
      return Updated(std::move(served), lease, core::RunSerially);
    });
  });
  const bool is_logged = storage::IsNewerFormat(status) && newer_logged_.exchange(true);
  if (!status.ok() && !absl::IsNotFound(status) && !is_logged) {
    spdlog::error("database '{}': {}: {}", database_.name(),
                  loads ? "cannot read the stored model"
                        : "update failed, changes wait for the next update or build",
                  status.ToString());
  }
  if (loads && status.ok()) RebuildIfOutdated().IgnoreError();
  if (loads && !status.ok()) SetLoadError(status);
  return status;
}

absl::StatusOr<ServedModel> ModelLifecycle::Updated(ServedModel served, const Lease& lease,
                                                    const core::ParallelFor& parallel) {
  if (served.snapshot == nullptr) return served;
  // First: a clip that is stored after the catalog was read belongs to a later revision.
  const auto catalog = database_.Catalog(services_.store.annotations());
  // Corrupt annotations do not keep clips out of the model.
  if (!catalog.ok() && !absl::IsDataLoss(catalog.status())) return catalog.status();
  const bool has_new_labels = catalog.ok() && (*catalog)->revision() != served.revision;
  const bool is_extensible = MayStore(lease) && IsExtensible(*served.snapshot);
  if (!is_extensible && !has_new_labels) return served;
  MOTIONDB_ASSIGN_OR_RETURN(auto staleness, services_.store.FindModelStaleness(database_.name()));
  if (is_extensible) {
    MOTIONDB_ASSIGN_OR_RETURN(served.snapshot,
                              Extended(std::move(served.snapshot), staleness, lease, parallel));
  }
  if (!has_new_labels) return served;
  return WithLabelsOf(**catalog, staleness, std::move(served));
}

absl::StatusOr<ServedModel> ModelLifecycle::Relabelled(ServedModel served) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, database_.Catalog(services_.store.annotations()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto staleness,
                            services_.store.FindModelStaleness(database_.name()));
  return WithLabelsOf(*catalog, staleness, std::move(served));
}

absl::StatusOr<ServedModel> ModelLifecycle::WithLabelsOf(const Catalog& catalog,
                                                         const storage::ModelStaleness& staleness,
                                                         ServedModel served) {
  auto labels = StoredLabels(served.snapshot->model, catalog);
  if (labels) {
    MOTIONDB_ASSIGN_OR_RETURN(core::Model model,
                              served.snapshot->model.WithLabels(*std::move(labels)));
    Snapshot snapshot{served.snapshot->record, std::move(model), served.snapshot->calibration,
                      served.snapshot->is_extensible};
    snapshot.has_fitted_labels = false;
    snapshot.view = served.snapshot->view;
    served.snapshot = std::make_shared<const Snapshot>(std::move(snapshot));
  }
  if (HasChangesOf(*served.snapshot, catalog, staleness)) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool is_current, IsCurrent(*served.snapshot));
    if (is_current) served.revision = std::max(served.revision, catalog.revision());
  }
  return served;
}

bool ModelLifecycle::HasChangesOf(const Snapshot& snapshot, const Catalog& catalog,
                                  const storage::ModelStaleness& staleness) const {
  // A model that is not stored cannot be compared with the stored states of its clips.
  if (!snapshot.is_stored()) return false;
  if (staleness.removed > 0 || staleness.outdated > 0 || staleness.to_derive > 0) return false;
  const auto unreadable = database_.unreadable();
  return std::ranges::all_of(staleness.missing, [&](const std::string& clip) {
    // A clip that was stored after the catalog was read belongs to a later revision.
    return unreadable.contains(clip) || catalog.Find(clip) == nullptr;
  });
}

absl::StatusOr<SnapshotPointer> ModelLifecycle::Extended(SnapshotPointer snapshot,
                                                         storage::ModelStaleness& staleness,
                                                         const Lease& lease,
                                                         const core::ParallelFor& parallel) {
  const std::string& name = database_.name();
  // A model with outdated states of clips is not extended: it will be replaced.
  if (snapshot->is_stored() && staleness.outdated > 0) return snapshot;
  std::set<std::string> known;
  for (const auto& [clip, problem] : database_.unreadable()) known.insert(clip);
  if (!snapshot->is_stored()) {
    for (const core::ModelClip& clip : snapshot->model.clips()) known.insert(clip.id);
  }
  const auto is_known = [&](const std::string& clip) { return known.contains(clip); };
  std::erase_if(staleness.missing, is_known);
  MOTIONDB_ASSIGN_OR_RETURN(
      auto extended,
      ModelWithClips(services_.store, database_, snapshot->model, staleness.missing, parallel));
  if (!extended) return snapshot;
  const double drift = extended->drift.stale;
  auto record = snapshot->is_stored()
                    ? services_.store.PutExtension(name, extended->model, drift, TermsOf(lease))
                    : ModelRecordOf(name, snapshot->record.version, extended->model, drift);
  if (absl::IsNotFound(record.status())) return snapshot;  // a clip was deleted meanwhile
  if (!record.ok()) return record.status();
  if (snapshot->is_stored()) stored_version_ = record->version;
  for (const core::ModelClip& clip : extended->model.clips()) known.insert(clip.id);
  std::erase_if(staleness.missing, is_known);
  spdlog::info(
      "database '{}': model {} extended: added_clips={} added_frames={:.2f} % "
      "frames_in_nodes_to_split={:.2f} %",
      name, record->version, record->added_clip_count, 100 * extended->drift.added, 100 * drift);
  return std::make_shared<const Snapshot>(Snapshot{*std::move(record), std::move(extended->model),
                                                   snapshot->calibration, snapshot->is_extensible,
                                                   snapshot->has_fitted_labels});
}

absl::StatusOr<bool> ModelLifecycle::HasAllClips(const Snapshot& snapshot) {
  if (!snapshot.is_stored() || LacksCalibration(snapshot.model)) return false;
  return HasAllClips(snapshot.record);
}

absl::StatusOr<bool> ModelLifecycle::HasAllClips(const storage::ModelRecord& record) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto staleness,
                            services_.store.FindModelStaleness(database_.name()));
  bool has_all = !HasDrifted(record) && staleness.removed == 0 && staleness.outdated == 0 &&
                 staleness.to_derive == 0;
  // Clips may be missing because they are corrupt. If one of them is readable, the model is out of
  // date, and the build reads the rest.
  for (auto clip = staleness.missing.begin(); has_all && clip != staleness.missing.end(); ++clip) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto read,
                              ReadInputs(services_.store, database_, {*clip}, core::RunSerially));
    has_all = read.empty();
  }
  return has_all;
}

}  // namespace motiondb::server
