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
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/reprocess.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/memory_reserve.h"
#include "server/engine/work/operation_registry.h"
#include "server/engine/work/shared_loop.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

// Shares of a build's progress: reading the clips and building the model; calibrating it.
constexpr double kBuildShare = 0.6;
constexpr double kCalibrateShare = 0.35;
// Share of deriving clips again in the progress of a build that does so.
constexpr double kDeriveShare = 0.5;

// The clocks of servers that share a store may differ by this. A clip that another one has derived
// up to this time after a request is derived again.
constexpr std::chrono::microseconds kMaxClockDifference = std::chrono::seconds(10);

// Maximum attempts of a build whose clips are deleted meanwhile.
constexpr int kAttempts = 8;

// A tree of one node cannot distinguish motions, but no call fails because of it.
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

}  // namespace

bool ModelLifecycle::TakesClips(double build_seconds) const {
  return build_seconds >= services_.options.extend_from.count();
}

std::shared_ptr<const Snapshot> ModelLifecycle::snapshot() const { return served().snapshot; }

ServedModel ModelLifecycle::served() const {
  const MutexLock lock(mutex_);
  return served_;
}

RebuildTally ModelLifecycle::rebuilds() const {
  const MutexLock lock(mutex_);
  return rebuilds_;
}

void ModelLifecycle::Serve(ServedModel next) {
  {
    const MutexLock lock(mutex_);
    if (served_.snapshot == nullptr) last_use_ = services_.executor.Now();
    std::swap(served_, next);
    // The old model, if no query uses it, is freed with the parameter, after the lock.
  }
  database_.signal()->Notify();
}

absl::Status ModelLifecycle::Replace(const Replacement& next) {
  const MutexLock lock(replace_mutex_);
  return database_.WithSharedUse(DeletionPolicy::kAwait, [&]() -> absl::Status {
    const std::int32_t version = stored_version_;
    auto replacement = next(served());
    const absl::Status status = replacement.status();
    if (status.ok()) {
      Serve(*std::move(replacement));
    } else if (stored_version_ != version && !absl::IsDataLoss(status)) {
      stored_version_ = -1;  // a model was read or stored, and is not served: it is read again
    }
    return status;
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
  auto lease = AcquireLease();
  const absl::Status acquired = lease.status();
  bool is_mine = acquired.ok();
  if (is_mine) {
    build.lease = *std::move(lease);
    unless_deleted([&] {
      is_mine = services_.operations.Start(build.operation);
    }).IgnoreError();  // the build detects the deletion itself
    // Otherwise another server has run it.
    if (!is_mine) return absl::OkStatus();
  }
  const auto built = WithoutExceptions<absl::StatusOr<Built>>([&]() -> absl::StatusOr<Built> {
    if (!is_mine) return acquired;
    return DeriveAndBuild(build);
  });
  if (EndUnfinished(build, built.status())) return built.status();
  const std::chrono::duration<double> took = services_.executor.Now() - began;
  {
    // Before the operation ends, so that its waiters see the count.
    const MutexLock lock(mutex_);
    ++(built.ok() ? rebuilds_.succeeded : build.stopped() ? rebuilds_.cancelled : rebuilds_.failed);
    rebuilds_.seconds += took.count();
  }
  absl::Status stored;
  const absl::Status ended = unless_deleted([&] {
    // After every build: storing a model also purges, but the build may not have stored one.
    PurgeDeletedClips({});
    stored = EndOperation(build, built);
  });
  if (!ended.ok()) services_.operations.Abandon(build.operation);
  if (!stored.ok()) {
    // It runs again, here or on another server, and finds the model up to date.
    services_.operations.HandOver(build.operation);
    build.is_deferred = true;
  }
  return built.status();
}

absl::Status ModelLifecycle::EndOperation(const Build& build, const absl::StatusOr<Built>& built) {
  OperationRegistry& operations = services_.operations;
  const std::string& name = database_.name();
  const StopReason stop = build.stop;
  if (built.ok()) {
    if (const auto current = snapshot()) WarnOfSingleNode(name, *current);
    spdlog::info("database '{}': model {} is current{}{}", name, built->version,
                 built->difference.empty() ? "" : ", ", built->difference);
    return operations.Succeed(build.operation, built->version, built->difference);
  }
  if (stop == StopReason::kShutdown) {
    operations.Postpone(build.operation);
  } else if (stop == StopReason::kCancelled) {
    spdlog::info("database '{}': rebuild cancelled", name);
    return operations.Cancel(build.operation);
  } else if (stop == StopReason::kForgotten || absl::IsNotFound(built.status())) {
    operations.Abandon(build.operation);  // deleted with its database
  } else {
    // ABORTED is caused by clients that keep deleting clips; each deletion requests a build.
    spdlog::log(absl::IsAborted(built.status()) ? spdlog::level::warn : spdlog::level::err,
                "database '{}': rebuild failed: {}", name, built.status().ToString());
    return operations.Fail(build.operation, built.status());
  }
  return absl::OkStatus();
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
  std::int64_t asked_time_us = 0;
  if (derives_all) {
    asked_time_us = std::max(operation->create_time_us, database_.scheme_time_us());
    if (is_shared()) asked_time_us += kMaxClockDifference.count();
  }
  const auto progress = [&](double fraction, std::string_view stage) {
    services_.operations.Advance(build.operation, kDeriveShare * fraction, stage);
    return !build.stopped();
  };
  const auto done = Reprocess(
      services_.store, database_, services_.executor.Parallel(Pool::kBuilds),
      TermsOf(build.lease).fence, asked_time_us, progress, [&build] { return build.stopped(); });
  if (absl::IsAborted(done.status()) && build.lease != nullptr) {
    // Another server has the lease, and continues.
    build.lease->Renew();
    // The store cannot be reached now; the next attempt will find that out.
    if (!build.lease->is_lost()) return absl::UnavailableError(done.status().message());
  }
  if (!done.ok()) return done.status();
  build.derived = kDeriveShare;
  return fmt::format("clips derived again: {}, changed: {}, failed: {}", done->clips, done->changed,
                     done->failed);
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::BuildUntilStored(Build& build) {
  absl::StatusOr<Built> built = absl::AbortedError("");
  for (int attempt = 0; attempt < kAttempts && absl::IsAborted(built.status()); ++attempt) {
    if (attempt > 0 && build.lease != nullptr && !build.lease->Renew()) return built;
    // First: the model then has at least the changes up to this revision.
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision,
                              services_.store.annotations().Revision(database_.name()));
    MOTIONDB_ASSIGN_OR_RETURN(auto clips, AllClips(services_.store, database_.name()));
    MOTIONDB_RETURN_IF_ERROR(CheckNoneIsNewer(clips));
    bool is_up_to_date = clips.empty();
    bool needs_refit = false;
    std::erase_if(clips, [](const storage::ClipRecord& clip) {
      return clip.representation_version != core::kRepresentationVersion;
    });
    if (clips.empty() && !is_up_to_date) {
      return core::DataLoss("database '{}': no clip could be derived again: {}", database_.name(),
                            database_.underived().begin()->second);
    }
    const Replacement without_build = [&](ServedModel current) -> absl::StatusOr<ServedModel> {
      auto followed = Followed(std::move(current), /*is_needed=*/true);
      if (!followed.ok() && !absl::IsDataLoss(followed.status())) return followed.status();
      current = followed.ok() ? *std::move(followed) : ServedModel();
      if (clips.empty()) {
        MOTIONDB_RETURN_IF_ERROR(DropStored(build.lease));
        current = {nullptr, revision};
      } else {
        MOTIONDB_ASSIGN_OR_RETURN(
            current, Updated(current, build.lease, services_.executor.Parallel(Pool::kBuilds)));
        if (const SnapshotPointer& model = current.snapshot; model != nullptr) {
          MOTIONDB_ASSIGN_OR_RETURN(const bool has_all, HasAllClips(*model));
          is_up_to_date = has_all && model->has_fitted_labels;
          // An extended model is built, so that it also has the best tree.
          needs_refit = has_all && !is_up_to_date && model->record.added_clip_count == 0;
        }
      }
      if (is_up_to_date) {
        built = Built{current.snapshot == nullptr ? 0 : current.snapshot->record.version, ""};
      }
      return current;
    };
    MOTIONDB_RETURN_IF_ERROR(Replace(without_build));
    if (build.stopped()) return absl::CancelledError("stopped");
    if (needs_refit) {
      built = RefitAndStore(build);
    } else if (!is_up_to_date) {
      built = BuildAndStore(build, clips, revision);
    }
  }
  return built;
}

absl::Status ModelLifecycle::DropStored(const Lease& lease) {
  absl::Status dropped = services_.store.DropModel(database_.name(), TermsOf(lease));
  if (dropped.ok()) stored_version_ = 0;
  return absl::IsNotFound(dropped) ? absl::OkStatus() : dropped;
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::RefitAndStore(const Build& build) {
  const core::ParallelFor parallel =
      Stoppable(services_.executor.Parallel(Pool::kBuilds), [&build] { return build.stopped(); });
  const auto progress = [this, &build](double fraction, std::string_view stage) {
    services_.operations.Advance(build.operation, fraction, stage);
    return !build.stopped();
  };
  const ServedModel before = served();
  MOTIONDB_ASSIGN_OR_RETURN(core::Model model,
                            core::RefitLabels(before.snapshot->model, parallel, progress));
  MOTIONDB_ASSIGN_OR_RETURN(const int version,
                            StoreAndServe(std::move(model), before.revision, build.lease));
  return Built{version, "labels refitted"};
}

absl::StatusOr<ModelLifecycle::Built> ModelLifecycle::BuildAndStore(
    const Build& build, const std::vector<storage::ClipRecord>& clips, std::int64_t revision) {
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
  MOTIONDB_RETURN_IF_ERROR(ServeBorrowing(model, revision, build.lease));
  Built built{.difference = DifferenceText(before.get(), model, parallel)};
  before.reset();  // frees its memory for the calibration

  MOTIONDB_RETURN_IF_ERROR(
      core::Calibrate(model, parallel, progress(kBuildShare, kCalibrateShare)));
  set_seconds(model);
  if (!advance(kBuildShare + kCalibrateShare, "storing")) return absl::CancelledError("stopped");
  MOTIONDB_ASSIGN_OR_RETURN(built.version, StoreAndServe(std::move(model), revision, build.lease));
  return built;
}

absl::Status ModelLifecycle::ServeBorrowing(core::Model model, std::int64_t revision,
                                            const Lease& lease) {
  return Replace([&](const ServedModel& current) -> absl::StatusOr<ServedModel> {
    if (lease != nullptr && lease->is_lost()) return absl::AbortedError("the lease is lost");
    const SnapshotPointer& before = current.snapshot;
    const bool can_borrow = before != nullptr && before->calibration != Calibration::kTypical;
    if (can_borrow) {
      model.set_recognition(before->model.recognition());
      model.set_confidence(before->model.confidence());
    }
    // Known clips must stay in the model, so an extensible model is replaced by an extensible one.
    const bool is_extensible =
        (before != nullptr && before->is_extensible) || TakesClips(model.build_seconds());
    const int stored_version = before == nullptr ? 0 : before->record.version;
    auto record = ModelRecordOf(database_.name(), stored_version, model, 0);
    spdlog::info("database '{}': serving a new model, calibration follows: clips={}",
                 database_.name(), record.clip_count);
    const auto snapshot = std::make_shared<const Snapshot>(
        Snapshot{std::move(record), std::move(model),
                 can_borrow ? Calibration::kPrevious : Calibration::kTypical, is_extensible});
    return Updated({snapshot, revision}, lease, services_.executor.Parallel(Pool::kBuilds));
  });
}

absl::StatusOr<int> ModelLifecycle::StoreAndServe(core::Model model, std::int64_t revision,
                                                  const Lease& lease) {
  int version = 0;
  MOTIONDB_RETURN_IF_ERROR(Replace([&](const ServedModel&) -> absl::StatusOr<ServedModel> {
    auto record = services_.store.PutModel(database_.name(), model, TermsOf(lease));
    if (!record.ok()) {
      return absl::IsNotFound(record.status())
                 ? absl::AbortedError(
                       "clips were deleted during each build; delete or ingest a clip to try again")
                 : record.status();
    }
    version = stored_version_ = record->version;
    const bool is_extensible = TakesClips(record->build_seconds);
    const auto stored = std::make_shared<const Snapshot>(
        Snapshot{*std::move(record), std::move(model), Calibration::kOwn, is_extensible});
    auto updated = Updated({stored, revision}, lease, services_.executor.Parallel(Pool::kBuilds));
    // The built model is stored: what changed meanwhile can wait for the next update.
    if (!updated.ok()) {
      spdlog::warn("database '{}': model {} could not be updated by changes during its build: {}",
                   database_.name(), version, updated.status().ToString());
      updated = ServedModel{stored, revision};
      stored_version_ = version;  // an extension that was stored is read again
    }
    return updated;
  }));
  return version;
}

void ModelLifecycle::PurgeDeletedClips(const core::Cancelled& cancelled) {
  const absl::Status purged = services_.store.PurgeDeletedClips(database_.name(), cancelled);
  if (!purged.ok() && !absl::IsCancelled(purged)) {
    spdlog::warn("database '{}': purge of deleted clips failed: {}", database_.name(),
                 purged.ToString());
  }
}

}  // namespace motiondb::server
