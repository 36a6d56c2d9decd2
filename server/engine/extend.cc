#include "server/engine/extend.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "core/model/extend_model.h"
#include "core/motion/error.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

bool HasDrifted(const storage::ModelRecord& record) {
  const double added = static_cast<double>(record.added_frame_count) / record.frame_count;
  return core::ModelDrift{added, record.stale_share}.IsLarge();
}

absl::StatusOr<storage::ModelGap> FindReadableGap(storage::MotionStore& store,
                                                  const LiveDatabase& database) {
  MOTIONDB_ASSIGN_OR_RETURN(storage::ModelGap gap, store.FindModelGap(database.name()));
  const auto unreadable = database.unreadable();
  std::erase_if(gap.missing, [&](const std::string& clip) { return unreadable.contains(clip); });
  return gap;
}

absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const std::function<bool(std::size_t)>& go_on) {
  std::vector<core::BuildInput> inputs;
  inputs.reserve(clips.size());
  for (const std::string& clip : clips) {
    if (!go_on(inputs.size())) return absl::CancelledError("stopped");
    const auto record = store.GetClip(database.name(), clip);
    auto states = record.ok() ? store.ReadClipStates(database.name(), clip) : record.status();
    if (absl::IsNotFound(states.status())) continue;
    if (absl::IsDataLoss(states.status())) {
      database.NoteUnreadable(clip, std::string(states.status().message()));
      continue;
    }
    if (!states.ok()) return states.status();
    database.ForgetUnreadable(clip);  // a disk may give back what it did not
    inputs.push_back({clip, record->label, *std::move(states), record->subject});
  }
  return inputs;
}

absl::StatusOr<std::shared_ptr<const Snapshot>> ExtendSnapshot(
    storage::MotionStore& store, LiveDatabase& database, std::shared_ptr<const Snapshot> snapshot,
    const EngineOptions& options, const core::ParallelFor& parallel) {
  if (snapshot->record.build_seconds < options.extend_from.count()) return snapshot;
  MOTIONDB_ASSIGN_OR_RETURN(const storage::ModelGap gap, FindReadableGap(store, database));
  if (gap.missing.empty() || !snapshot->model.tree().has_planes()) return snapshot;
  MOTIONDB_ASSIGN_OR_RETURN(
      auto inputs, ReadInputs(store, database, gap.missing, [](std::size_t) { return true; }));
  if (inputs.empty()) return snapshot;
  MOTIONDB_ASSIGN_OR_RETURN(core::Model model,
                            core::ExtendModel(snapshot->model, std::move(inputs), parallel));
  const core::ModelDrift drift = core::MeasureDrift(model, parallel);
  auto record = store.PutExtension(database.name(), model, drift.stale);
  if (absl::IsNotFound(record.status())) return snapshot;  // a clip was deleted meanwhile
  if (!record.ok()) return record.status();
  spdlog::info(
      "database '{}': model {} was extended, clips more than the build: {}; {:.2f} % of its frames "
      "were added, {:.2f} % lie in nodes that a build would divide",
      database.name(), record->version, record->added_clip_count, 100 * drift.added,
      100 * drift.stale);
  return std::make_shared<const Snapshot>(Snapshot{*std::move(record), std::move(model)});
}

absl::Status Extend(storage::MotionStore& store, LiveDatabase& database,
                    const EngineOptions& options, const core::ParallelFor& parallel) {
  const std::lock_guard lock(database.model_mutex());
  return database.WhileAlive(Retiring::kAwait, [&]() -> absl::Status {
    const std::shared_ptr<const Snapshot> current = database.snapshot();
    if (current == nullptr) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(auto extended,
                              ExtendSnapshot(store, database, current, options, parallel));
    if (extended != current) database.set_snapshot(std::move(extended));
    return absl::OkStatus();
  });
}

}  // namespace motiondb::server
