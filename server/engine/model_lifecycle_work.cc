// Work of a ModelLifecycle on the threads for builds and extensions: the replacements of the model.
#include <spdlog/spdlog.h>

#include <exception>
#include <new>
#include <set>
#include <utility>

#include "core/calibration/calibrate.h"
#include "core/motion/error.h"
#include "core/tree/split_node.h"
#include "server/engine/compute_model.h"
#include "server/engine/corruption_log.h"
#include "server/engine/live_database.h"
#include "server/engine/memory_reserve.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operation_registry.h"
#include "server/engine/options.h"
#include "server/engine/reprocess.h"
#include "server/engine/shared_loop.h"
#include "server/engine/stored_clips.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

// Shares of a build's progress: reading the clips and building the model; calibrating it.
constexpr double kBuildShare = 0.6;
constexpr double kCalibrateShare = 0.35;
// Share of deriving clips again in the progress of a build that does so.
constexpr double kDeriveShare = 0.5;

// Maximum attempts of a build whose clips are deleted meanwhile.
constexpr int kAttempts = 8;

// Models of older versions have no calibration for unknown motion. Models without a metric cannot
// have one.
bool LacksCalibration(const core::Model& model) {
  return !model.metric().empty() &&
         model.recognition().unknown == core::UnknownCalibration::kNotFitted;
}

// A tree of one node cannot tell motions apart, but no call fails because of it.
void WarnOfSingleNode(const std::string& database, const Snapshot& snapshot) {
  const core::Model& model = snapshot.model;
  if (core::IsSingleNode(model.tree(), model.settings().min_frames)) {
    spdlog::warn(
        "database '{}': the tree of model {} is a single node of {} frames, so answers do not "
        "distinguish motions: all frames are alike, or some frames are far from all others; "
        "check the clips that were ingested last for glitches",
        database, snapshot.record.version, model.frame_count());
  }
}

bool TakesClips(const EngineOptions& options, double build_seconds) {
  return build_seconds >= options.extend_from.count();
}

// Runs work of a build or an extension; converts exceptions to a status.
template <typename Result, typename Work>
Result WithoutExceptions(const Work& work) {
  Result result;
  try {
    const AllocationsMayFail scope;
    result = work();
  } catch (const WorkStopped&) {
    result = absl::CancelledError("stopped");
  } catch (const std::bad_alloc&) {
    result = absl::ResourceExhaustedError("not enough memory to build the model");
  } catch (const std::exception& error) {
    result = absl::InternalError(error.what());
  }
  return result;
}

}  // namespace

void ModelLifecycle::LoadStored(CorruptionLog& corruptions) {
  const std::string& name = database_.name();
  auto model = services_.store.ReadModel(name, services_.executor.Parallel(Pool::kRequests));
  if (absl::IsNotFound(model.status())) return;
  auto newest = services_.store.ListModels(name, 0, 1);
  const absl::Status status = model.ok() ? newest.status() : model.status();
  if (status.ok() && !newest->empty()) {
    const bool is_extensible = TakesClips(services_.options, newest->front().build_seconds);
    return Serve(std::make_shared<const Snapshot>(
        Snapshot{newest->front(), *std::move(model), Calibration::kOwn, is_extensible}));
  }
  spdlog::error("database '{}': cannot read the stored model: {}", name, status.ToString());
  if (!absl::IsDataLoss(status)) return;
  const int version = newest.ok() && !newest->empty() ? newest->front().version : 0;
  corruptions.Note(
      {fmt::format("databases/{}/models/{}", name, version), std::string(status.message())});
}

std::shared_ptr<const Snapshot> ModelLifecycle::snapshot() const {
  const MutexLock lock(mutex_);
  return snapshot_;
}

RebuildTally ModelLifecycle::rebuilds() const {
  const MutexLock lock(mutex_);
  return rebuilds_;
}

void ModelLifecycle::Serve(SnapshotPointer snapshot) {
  const MutexLock lock(mutex_);
  snapshot_.swap(snapshot);
  // The old model, if no query uses it, is freed with the parameter, after the lock.
}

absl::Status ModelLifecycle::Replace(const Replacement& next) {
  const MutexLock lock(replace_mutex_);
  return database_.WithSharedUse(DeletionPolicy::kAwait, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer replacement, next(snapshot()));
    Serve(std::move(replacement));
    return absl::OkStatus();
  });
}

absl::Status ModelLifecycle::RunBuild(Build& build) {
  // Operations of a deleted database are not stored: a new database may have its name.
  const auto unless_deleted = [&](const std::function<void()>& store) {
    return database_.WithSharedUse(DeletionPolicy::kAwait, [&] {
      store();
      return absl::OkStatus();
    });
  };
  const auto began = services_.executor.Now();
  unless_deleted([&] {
    services_.operations.Start(build.operation);
  }).IgnoreError();  // the build detects the deletion itself
  const auto built =
      WithoutExceptions<absl::StatusOr<Built>>([&] { return DeriveAndBuild(build); });
  const std::chrono::duration<double> took = services_.executor.Now() - began;
  {
    // Before the operation ends, so that its waiters see the count.
    const MutexLock lock(mutex_);
    ++(built.ok() ? rebuilds_.succeeded : build.stopped() ? rebuilds_.cancelled : rebuilds_.failed);
    rebuilds_.seconds += took.count();
  }
  const absl::Status ended = unless_deleted([&] {
    // After every build: storing a model also purges, but the build may not have stored one.
    PurgeDeletedClips({});
    EndOperation(build, built);
  });
  if (!ended.ok()) services_.operations.Abandon(build.operation);
  return built.status();
}

void ModelLifecycle::EndOperation(const Build& build, const absl::StatusOr<Built>& built) {
  OperationRegistry& operations = services_.operations;
  const std::string& name = database_.name();
  const StopReason stop = build.stop;
  if (built.ok()) {
    if (const auto current = snapshot()) WarnOfSingleNode(name, *current);
    operations.Succeed(build.operation, built->version, built->difference);
    spdlog::info("database '{}': model {} is current{}{}", name, built->version,
                 built->difference.empty() ? "" : ", ", built->difference);
  } else if (stop == StopReason::kShutdown) {
    operations.Postpone(build.operation);
  } else if (stop == StopReason::kCancelled) {
    spdlog::info("database '{}': rebuild cancelled", name);
    operations.Cancel(build.operation).IgnoreError();
  } else if (stop == StopReason::kForgotten || absl::IsNotFound(built.status())) {
    operations.Abandon(build.operation);  // deleted with its database
  } else {
    // ABORTED is caused by clients that keep deleting clips; each deletion requests a build.
    spdlog::log(absl::IsAborted(built.status()) ? spdlog::level::warn : spdlog::level::err,
                "database '{}': rebuild failed: {}", name, built.status().ToString());
    operations.Fail(build.operation, built.status());
  }
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::DeriveAndBuild(Build& build) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string derived, DeriveOutdated(build));
  auto built = BuildUntilStored(build);
  if (built.ok() && !derived.empty()) {
    built->difference = built->difference.empty() ? derived : derived + "; " + built->difference;
  }
  return built;
}

absl::StatusOr<std::string> ModelLifecycle::DeriveOutdated(Build& build) {
  const auto operation = services_.operations.Get(build.operation);
  const bool derives_all = operation.ok() && operation->kind == storage::OperationKind::kReprocess;
  MOTIONDB_ASSIGN_OR_RETURN(const auto staleness,
                            services_.store.FindModelStaleness(database_.name()));
  if (staleness.to_derive == 0 && !derives_all) return std::string();
  const auto progress = [&](double fraction, std::string_view stage) {
    services_.operations.Advance(build.operation, kDeriveShare * fraction, stage);
    return !build.stopped();
  };
  MOTIONDB_ASSIGN_OR_RETURN(
      const Reprocessed done,
      Reprocess(services_.store, database_, services_.executor.Parallel(Pool::kBuilds),
                derives_all ? std::max(operation->create_time_us, database_.scheme_time_us()) : 0,
                progress, [&build] { return build.stopped(); }));
  build.derived = kDeriveShare;
  return fmt::format("clips derived again: {}, changed: {}, failed: {}", done.clips, done.changed,
                     done.failed);
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::BuildUntilStored(const Build& build) {
  absl::StatusOr<Built> built = absl::AbortedError("");
  for (int attempt = 0; attempt < kAttempts && absl::IsAborted(built.status()); ++attempt) {
    MOTIONDB_ASSIGN_OR_RETURN(auto clips, AllClips(services_.store, database_.name()));
    bool is_up_to_date = clips.empty();
    std::erase_if(clips, [](const storage::ClipRecord& clip) {
      return clip.representation_version != core::kRepresentationVersion;
    });
    if (clips.empty() && !is_up_to_date) {
      return core::DataLoss("database '{}': no clip could be derived again: {}", database_.name(),
                            database_.underived().begin()->second);
    }
    const Replacement without_build =
        [&](SnapshotPointer current) -> absl::StatusOr<SnapshotPointer> {
      if (clips.empty()) {
        MOTIONDB_RETURN_IF_ERROR(DropStored());
        current = nullptr;
      } else {
        MOTIONDB_ASSIGN_OR_RETURN(current,
                                  Extended(current, services_.executor.Parallel(Pool::kBuilds)));
        if (current != nullptr) {
          MOTIONDB_ASSIGN_OR_RETURN(is_up_to_date, HasAllClips(*current));
        }
      }
      if (is_up_to_date) built = Built{current == nullptr ? 0 : current->record.version, ""};
      return current;
    };
    MOTIONDB_RETURN_IF_ERROR(Replace(without_build));
    if (build.stopped()) return absl::CancelledError("stopped");
    if (!is_up_to_date) built = BuildAndStore(build, clips);
  }
  return built;
}

absl::Status ModelLifecycle::DropStored() {
  absl::Status dropped = services_.store.DropModel(database_.name());
  return absl::IsNotFound(dropped) ? absl::OkStatus() : dropped;
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::BuildAndStore(
    const Build& build, const std::vector<storage::ClipRecord>& clips) {
  // Computing can stop at any moment; storing and serving cannot.
  const core::ParallelFor parallel =
      Stoppable(services_.executor.Parallel(Pool::kBuilds), [&build] { return build.stopped(); });
  const auto advance = [this, &build](double fraction, std::string_view stage) {
    services_.operations.Advance(build.operation, build.derived + (1 - build.derived) * fraction,
                                 stage);
    return !build.stopped();
  };
  const auto progress = [&](double from, double share) -> core::BuildProgress {
    return [&advance, from, share](double fraction, std::string_view stage) {
      return advance(from + share * fraction, stage);
    };
  };
  const auto began = services_.executor.Now();
  const auto set_seconds = [&](core::Model& model) {
    const std::chrono::duration<double> seconds = services_.executor.Now() - began;
    model.set_build_seconds(seconds.count());
  };
  MOTIONDB_ASSIGN_OR_RETURN(core::Model model, ModelOfClips(services_.store, database_, clips,
                                                            parallel, progress(0, kBuildShare)));
  set_seconds(model);
  SnapshotPointer before = snapshot();
  MOTIONDB_RETURN_IF_ERROR(ServeBorrowing(model));
  Built built{.difference = DifferenceText(before.get(), model, parallel)};
  before.reset();  // frees its memory for the calibration

  MOTIONDB_RETURN_IF_ERROR(
      core::Calibrate(model, parallel, progress(kBuildShare, kCalibrateShare)));
  set_seconds(model);
  if (!advance(kBuildShare + kCalibrateShare, "storing")) return absl::CancelledError("stopped");
  MOTIONDB_ASSIGN_OR_RETURN(built.version, StoreAndServe(std::move(model)));
  return built;
}

absl::Status ModelLifecycle::ServeBorrowing(core::Model model) {
  return Replace([&](const SnapshotPointer& before) -> absl::StatusOr<SnapshotPointer> {
    const bool can_borrow = before != nullptr && before->calibration != Calibration::kTypical;
    if (can_borrow) {
      model.set_recognition(before->model.recognition());
      model.set_confidence(before->model.confidence());
    }
    // Known clips must stay in the model, so an extensible model is replaced by an extensible one.
    const bool is_extensible = (before != nullptr && before->is_extensible) ||
                               TakesClips(services_.options, model.build_seconds());
    const int stored_version = before == nullptr ? 0 : before->record.version;
    auto record = ModelRecordOf(database_.name(), stored_version, model, 0);
    spdlog::info("database '{}': serving a new model, calibration follows: clips={}",
                 database_.name(), record.clip_count);
    return Extended(
        std::make_shared<const Snapshot>(
            Snapshot{std::move(record), std::move(model),
                     can_borrow ? Calibration::kPrevious : Calibration::kTypical, is_extensible}),
        services_.executor.Parallel(Pool::kBuilds));
  });
}

absl::StatusOr<int> ModelLifecycle::StoreAndServe(core::Model model) {
  int version = 0;
  MOTIONDB_RETURN_IF_ERROR(Replace([&](const SnapshotPointer&) -> absl::StatusOr<SnapshotPointer> {
    auto record = services_.store.PutModel(database_.name(), model);
    if (!record.ok()) {
      return absl::IsNotFound(record.status())
                 ? absl::AbortedError(
                       "clips were deleted during each build; delete or ingest a clip to try again")
                 : record.status();
    }
    version = record->version;
    const bool is_extensible = TakesClips(services_.options, record->build_seconds);
    const auto stored = std::make_shared<const Snapshot>(
        Snapshot{*std::move(record), std::move(model), Calibration::kOwn, is_extensible});
    auto extended = Extended(stored, services_.executor.Parallel(Pool::kBuilds));
    // The built model is stored: clips that came meanwhile can wait for the next extension.
    if (!extended.ok()) {
      spdlog::warn(
          "database '{}': model {} could not be extended by clips ingested during its build: {}",
          database_.name(), version, extended.status().ToString());
      extended = stored;
    }
    return extended;
  }));
  return version;
}

void ModelLifecycle::ExtendCurrent() {
  const absl::Status status = WithoutExceptions<absl::Status>([&] {
    return Replace(
        [&](SnapshotPointer current) { return Extended(std::move(current), core::RunSerially); });
  });
  if (!status.ok() && !absl::IsNotFound(status)) {
    spdlog::error("database '{}': extension failed, new clips wait for the next build: {}",
                  database_.name(), status.ToString());
  }
}

absl::StatusOr<SnapshotPointer> ModelLifecycle::Extended(SnapshotPointer snapshot,
                                                         const core::ParallelFor& parallel) {
  const std::string& name = database_.name();
  const bool is_extensible =
      snapshot != nullptr && snapshot->is_extensible && snapshot->model.tree().has_planes();
  if (!is_extensible) return snapshot;
  MOTIONDB_ASSIGN_OR_RETURN(auto staleness, services_.store.FindModelStaleness(name));
  // A model with outdated states of clips is not extended: it will be replaced.
  if (snapshot->is_stored() && staleness.outdated > 0) return snapshot;
  std::set<std::string> known;
  for (const auto& [clip, problem] : database_.unreadable()) known.insert(clip);
  if (!snapshot->is_stored()) {
    for (const core::ModelClip& clip : snapshot->model.clips()) known.insert(clip.id);
  }
  std::erase_if(staleness.missing, [&](const std::string& clip) { return known.contains(clip); });
  MOTIONDB_ASSIGN_OR_RETURN(
      auto extended,
      ModelWithClips(services_.store, database_, snapshot->model, staleness.missing, parallel));
  if (!extended) return snapshot;
  const double drift = extended->drift.stale;
  auto record = snapshot->is_stored()
                    ? services_.store.PutExtension(name, extended->model, drift)
                    : ModelRecordOf(name, snapshot->record.version, extended->model, drift);
  if (absl::IsNotFound(record.status())) return snapshot;  // a clip was deleted meanwhile
  if (!record.ok()) return record.status();
  spdlog::info(
      "database '{}': model {} extended: added_clips={} added_frames={:.2f} % "
      "frames_in_nodes_to_split={:.2f} %",
      name, record->version, record->added_clip_count, 100 * extended->drift.added, 100 * drift);
  return std::make_shared<const Snapshot>(Snapshot{*std::move(record), std::move(extended->model),
                                                   snapshot->calibration, snapshot->is_extensible});
}

absl::StatusOr<bool> ModelLifecycle::HasAllClips(const Snapshot& snapshot) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto staleness,
                            services_.store.FindModelStaleness(database_.name()));
  bool has_all = snapshot.is_stored() && !HasDrifted(snapshot.record) && staleness.removed == 0 &&
                 staleness.outdated == 0 && staleness.to_derive == 0 &&
                 !LacksCalibration(snapshot.model);
  // Clips may be missing because they are corrupt. If one of them is readable, the model is out of
  // date, and the build reads the rest.
  for (auto clip = staleness.missing.begin(); has_all && clip != staleness.missing.end(); ++clip) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto read,
                              ReadInputs(services_.store, database_, {*clip}, core::RunSerially));
    has_all = read.empty();
  }
  return has_all;
}

void ModelLifecycle::PurgeDeletedClips(const core::Cancelled& cancelled) {
  const absl::Status purged = services_.store.PurgeDeletedClips(database_.name(), cancelled);
  if (!purged.ok() && !absl::IsCancelled(purged)) {
    spdlog::warn("database '{}': purge of deleted clips failed: {}", database_.name(),
                 purged.ToString());
  }
}

}  // namespace motiondb::server
