#include "server/engine/rebuild.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/motion/error.h"
#include "server/engine/clip_list.h"

namespace motiondb::server {
namespace {

// Parts of the whole that reading the clips, building the model and calibrating it take.
constexpr double kReadShare = 0.1;
constexpr double kBuildShare = 0.5;
constexpr double kCalibrateShare = 0.35;

// How often a build begins again because a clip of it was deleted.
constexpr int kAttempts = 8;

absl::Status DropModel(storage::MotionStore& store, LiveDatabase& database) {
  return database.WhileAlive([&] {
    const absl::Status dropped = store.DropModel(database.name());
    if (!dropped.ok() && !absl::IsNotFound(dropped)) return dropped;
    database.set_snapshot(nullptr);
    return absl::OkStatus();
  });
}

absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, const std::vector<storage::ClipRecord>& clips,
    const core::BuildProgress& progress) {
  std::vector<core::BuildInput> inputs;
  inputs.reserve(clips.size());
  for (const storage::ClipRecord& clip : clips) {
    const double read = static_cast<double>(inputs.size()) / static_cast<double>(clips.size());
    if (!progress(kReadShare * read, "reading clips")) return absl::CancelledError("stopped");
    auto states = store.ReadClipStates(clip.database, clip.id);
    if (absl::IsNotFound(states.status())) continue;  // deleted meanwhile
    if (!states.ok()) return states.status();
    inputs.push_back({clip.id, clip.label, *std::move(states), clip.subject});
  }
  return inputs;
}

// Whether every clip of the model is still stored.
absl::StatusOr<bool> StillStored(storage::MotionStore& store, const std::string& database,
                                 const core::Model& model) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto clips, AllClips(store, database));
  return std::ranges::all_of(model.clips(), [&](const core::ModelClip& in_model) {
    return std::ranges::binary_search(clips, in_model.id, {}, &storage::ClipRecord::id);
  });
}

// Stores the model and swaps it in. Returns 0 if a clip of it was deleted during the build.
absl::StatusOr<int> Commit(storage::MotionStore& store, LiveDatabase& database, core::Model model) {
  int version = 0;
  const absl::Status status = database.WhileAlive([&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const bool whole, StillStored(store, database.name(), model));
    if (!whole) return absl::OkStatus();
    auto record = store.PutModel(database.name(), model);
    if (absl::IsNotFound(record.status())) return absl::OkStatus();  // deleted since the check
    if (!record.ok()) return record.status();
    version = record->version;
    database.set_snapshot(
        std::make_shared<const Snapshot>(Snapshot{*std::move(record), std::move(model)}));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return version;
}

absl::StatusOr<core::Model> Build(storage::MotionStore& store, LiveDatabase& database,
                                  const std::vector<storage::ClipRecord>& clips,
                                  const core::ParallelFor& parallel,
                                  const core::BuildProgress& progress) {
  const auto began = std::chrono::steady_clock::now();
  MOTIONDB_ASSIGN_OR_RETURN(auto inputs, ReadInputs(store, clips, progress));
  if (inputs.empty()) return absl::AbortedError("all clips were deleted meanwhile");
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  if (scheme == nullptr) {
    return absl::InternalError(
        fmt::format("database '{}' has clips but no markers", database.name()));
  }
  const auto build_progress = [&](double fraction, std::string_view stage) {
    return progress(kReadShare + kBuildShare * fraction, stage);
  };
  MOTIONDB_ASSIGN_OR_RETURN(core::Model model,
                            core::BuildModel(database.settings(), scheme->set, std::move(inputs),
                                             parallel, build_progress));
  const auto calibrate_progress = [&](double fraction, std::string_view stage) {
    return progress(kReadShare + kBuildShare + kCalibrateShare * fraction, stage);
  };
  MOTIONDB_RETURN_IF_ERROR(core::Calibrate(model, parallel, calibrate_progress));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  model.set_build_seconds(took.count());
  return model;
}

}  // namespace

absl::StatusOr<int> Rebuild(storage::MotionStore& store, LiveDatabase& database,
                            const core::ParallelFor& parallel,
                            const core::BuildProgress& progress) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto clips, AllClips(store, database.name()));
    if (clips.empty()) {
      MOTIONDB_RETURN_IF_ERROR(DropModel(store, database));
      return 0;
    }
    const std::shared_ptr<const Snapshot> current = database.snapshot();
    if (current != nullptr && IsBuiltFrom(*current, clips)) return current->record.version;

    absl::StatusOr<core::Model> model = Build(store, database, clips, parallel, progress);
    if (absl::IsAborted(model.status())) continue;
    if (!model.ok()) return model.status();
    if (!progress(kReadShare + kBuildShare + kCalibrateShare, "storing")) {
      return absl::CancelledError("stopped");
    }
    MOTIONDB_ASSIGN_OR_RETURN(const int version, Commit(store, database, *std::move(model)));
    if (version != 0) return version;
    // A clip of the model was deleted during the build: build again without it.
  }
  return absl::AbortedError(
      "clips were deleted during each build; delete or ingest one to try again");
}

}  // namespace motiondb::server
