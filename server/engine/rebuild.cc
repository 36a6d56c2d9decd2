#include "server/engine/rebuild.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/model_difference.h"
#include "core/motion/error.h"
#include "server/engine/clip_list.h"
#include "server/engine/extend.h"
#include "server/engine/purge.h"
#include "server/engine/stoppable.h"

namespace motiondb::server {
namespace {

// Parts of the whole that reading the clips, building the model and calibrating it take.
constexpr double kReadShare = 0.1;
constexpr double kBuildShare = 0.5;
constexpr double kCalibrateShare = 0.35;

// How often a build begins again because a clip of it was deleted.
constexpr int kAttempts = 8;

absl::Status DropModel(storage::MotionStore& store, LiveDatabase& database) {
  const std::lock_guard lock(database.model_mutex());
  return database.WhileAlive(Retiring::kAwait, [&] {
    const absl::Status dropped = store.DropModel(database.name());
    if (!dropped.ok() && !absl::IsNotFound(dropped)) return dropped;
    database.set_snapshot(nullptr);
    return absl::OkStatus();
  });
}

// The version of the current model if it may stay, else 0.
absl::StatusOr<int> VersionThatStays(storage::MotionStore& store, LiveDatabase& database) {
  const std::lock_guard lock(database.model_mutex());
  const std::shared_ptr<const Snapshot> current = database.snapshot();
  if (current == nullptr) return 0;
  MOTIONDB_ASSIGN_OR_RETURN(const storage::ModelGap gap, FindReadableGap(store, database));
  return gap.empty() && !HasDrifted(current->record) ? current->record.version : 0;
}

std::string DifferenceText(const Snapshot* before, const core::Model& built,
                           const core::ParallelFor& parallel) {
  if (before == nullptr || before->record.added_clip_count == 0) return "";
  const core::ModelDifference difference = core::CompareModels(before->model, built, parallel);
  return fmt::format(
      "in place of one with added clips ({}): bottom nodes {} -> {}, rms distance of frames from "
      "their node's "
      "mean {:.4f} -> {:.4f}, same label for {} of {} left-out windows",
      before->record.added_clip_count, difference.bottom_nodes_before,
      difference.bottom_nodes_after, difference.spread_before, difference.spread_after,
      difference.same_label, difference.windows);
}

// Stores the model and swaps it in. Returns 0 if nothing is left of a clip that it was built from.
absl::StatusOr<int> Commit(storage::MotionStore& store, LiveDatabase& database, core::Model model,
                           const EngineOptions& options, const core::ParallelFor& parallel) {
  int version = 0;
  const std::lock_guard lock(database.model_mutex());
  const absl::Status status = database.WhileAlive(Retiring::kAwait, [&]() -> absl::Status {
    auto record = store.PutModel(database.name(), model);
    if (absl::IsNotFound(record.status())) return absl::OkStatus();
    if (!record.ok()) return record.status();
    version = record->version;
    auto built = std::make_shared<const Snapshot>(Snapshot{*std::move(record), std::move(model)});
    auto extended = ExtendSnapshot(store, database, built, options, parallel);
    // The build is in: clips that came meanwhile can wait for the next extension.
    if (!extended.ok()) {
      spdlog::warn(
          "database '{}': model {} could not be extended by the clips that came during "
          "its build: {}",
          database.name(), version, extended.status().ToString());
    }
    database.set_snapshot(extended.ok() ? *std::move(extended) : std::move(built));
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
  std::vector<std::string> ids;
  for (const storage::ClipRecord& clip : clips) ids.push_back(clip.id);
  const auto read_progress = [&](std::size_t read) {
    const double share = static_cast<double>(read) / static_cast<double>(ids.size());
    return progress(kReadShare * share, "reading clips");
  };
  MOTIONDB_ASSIGN_OR_RETURN(auto inputs, ReadInputs(store, database, ids, read_progress));
  if (inputs.empty()) {
    if (database.unreadable().empty())
      return absl::AbortedError("all clips were deleted meanwhile");
    return core::DataLoss("database '{}': no clip can be read, all are damaged: {}",
                          database.name(), database.unreadable().begin()->second);
  }
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

// What is only computed can be given up at any moment; what is stored and served comes after it.
absl::StatusOr<core::Model> BuildUnlessStopped(storage::MotionStore& store, LiveDatabase& database,
                                               const std::vector<storage::ClipRecord>& clips,
                                               const core::ParallelFor& parallel,
                                               const core::BuildProgress& progress) {
  try {
    return Build(store, database, clips, parallel, progress);
  } catch (const WorkStopped&) {
    return absl::CancelledError("stopped");
  }
}

absl::StatusOr<Rebuilt> BuildUntilStored(storage::MotionStore& store, LiveDatabase& database,
                                         const EngineOptions& options,
                                         const core::ParallelFor& parallel,
                                         const core::BuildProgress& progress,
                                         const core::Cancelled& stopped) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto clips, AllClips(store, database.name()));
    if (clips.empty()) {
      MOTIONDB_RETURN_IF_ERROR(DropModel(store, database));
      return Rebuilt{};
    }
    MOTIONDB_RETURN_IF_ERROR(Extend(store, database, options, parallel));
    MOTIONDB_ASSIGN_OR_RETURN(const int stays, VersionThatStays(store, database));
    if (stays != 0) return Rebuilt{stays, ""};

    absl::StatusOr<core::Model> model =
        BuildUnlessStopped(store, database, clips, Stoppable(parallel, stopped), progress);
    if (absl::IsAborted(model.status())) continue;
    if (!model.ok()) return model.status();
    if (!progress(kReadShare + kBuildShare + kCalibrateShare, "storing")) {
      return absl::CancelledError("stopped");
    }
    std::string difference = DifferenceText(database.snapshot().get(), *model, parallel);
    MOTIONDB_ASSIGN_OR_RETURN(const int version,
                              Commit(store, database, *std::move(model), options, parallel));
    if (version != 0) return Rebuilt{version, std::move(difference)};
    // The model was dropped meanwhile, with what was left of deleted clips: build again.
  }
  return absl::AbortedError(
      "clips were deleted during each build; delete or ingest one to try again");
}

}  // namespace

absl::StatusOr<Rebuilt> Rebuild(storage::MotionStore& store, LiveDatabase& database,
                                const EngineOptions& options, const core::ParallelFor& parallel,
                                const core::BuildProgress& progress,
                                const core::Cancelled& stopped) {
  const std::lock_guard states(database.states_mutex());
  auto rebuilt = BuildUntilStored(store, database, options, parallel, progress, stopped);
  // However it ended: putting a model does this, but the current one may have stayed.
  database
      .WhileAlive(Retiring::kAwait,
                  [&] {
                    PurgeDeletedClips(store, database.name());
                    return absl::OkStatus();
                  })
      .IgnoreError();  // where the database was deleted, so were they
  return rebuilt;
}

}  // namespace motiondb::server
