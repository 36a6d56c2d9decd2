// What a ModelLifecycle does because several servers share the store.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/operation_registry.h"
#include "storage/blob/newer_format.h"

namespace motiondb::server {

using storage::MutexLock;

absl::StatusOr<ModelLifecycle::Lease> ModelLifecycle::AcquireLease() {
  if (!is_shared()) return Lease();
  const MutexLock lock(lease_mutex_);
  if (auto held = lease_.lock(); held != nullptr && !held->is_lost()) return held;
  auto acquired =
      BuildLease::Acquire(services_.store, services_.executor, database_.name(), services_.holder);
  if (absl::IsAborted(acquired.status())) ++refused_leases_;
  if (!acquired.ok()) return acquired.status();
  // The lease names a database. If it was created again later, the lease is lost.
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, services_.store.GetDatabase(database_.name()));
  if (record.id != database_.id()) {
    return core::NotFound("database '{}' was deleted and created again", database_.name());
  }
  ++acquired_leases_;
  lease_ = *acquired;
  return acquired;
}

LeaseTally ModelLifecycle::leases() const {
  LeaseTally tally{.acquired = acquired_leases_, .refused = refused_leases_, .lost = lost_leases_};
  // If it is locked, the lease is being acquired, for which the caller does not wait.
  if (lease_mutex_.try_lock()) {
    tally.is_held = !lease_.expired();
    lease_mutex_.unlock();
  }
  return tally;
}

ModelLifecycle::Lease ModelLifecycle::HeldLease() {
  const MutexLock lock(lease_mutex_);
  auto held = lease_.lock();
  return held != nullptr && !held->is_lost() ? held : nullptr;
}

storage::ModelTerms ModelLifecycle::TermsOf(const Lease& lease) const {
  if (lease == nullptr) return {};
  return {stored_version_, lease->fence()};
}

absl::StatusOr<ServedModel> ModelLifecycle::Followed(ServedModel served, bool is_needed) {
  if (!is_shared() && served.unloaded == nullptr) return served;
  const std::string& name = database_.name();
  const bool reads = is_needed || served.snapshot != nullptr || !loads_on_demand();
  MOTIONDB_ASSIGN_OR_RETURN(auto newest, services_.store.ListModels(name, 0, 1));
  const bool has_model = !newest.empty() && newest.front().current;
  const bool is_known = (has_model ? newest.front().version : 0) == stored_version_;
  if (is_known && (served.unloaded == nullptr || !reads)) return served;
  if (has_model && reads) return ReadNewer(served, std::move(newest.front()));
  if (has_model) {
    stored_version_ = newest.front().version;
    return Unloaded(std::move(newest.front()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, database_.Catalog(services_.store.annotations()));
  stored_version_ = 0;
  return ServedModel{nullptr, catalog->stored().clip_count == 0 ? catalog->revision() : 0};
}

absl::StatusOr<ServedModel> ModelLifecycle::ReadNewer(const ServedModel& served,
                                                      storage::ModelRecord newest) {
  const std::string& name = database_.name();
  const core::ParallelFor parallel = services_.executor.Parallel(Pool::kRequests);
  const SnapshotPointer& before = served.snapshot;
  while (true) {
    absl::StatusOr<core::Model> model = absl::FailedPreconditionError("");
    if (before != nullptr && before->is_stored()) {
      model = services_.store.ReadExtension(name, before->record.version, before->model, parallel);
    }
    const bool is_extension = model.ok();
    if (absl::IsFailedPrecondition(model.status())) {
      model = services_.store.ReadModel(name, parallel);
    }
    MOTIONDB_ASSIGN_OR_RETURN(auto again, services_.store.ListModels(name, 0, 1));
    if (again.empty() || !again.front().current) return Followed({}, /*is_needed=*/true);
    if (again.front().version != newest.version) {
      newest = std::move(again.front());
      continue;
    }
    // A corrupt model is not read again; a build replaces it.
    if (model.ok() || absl::IsDataLoss(model.status())) stored_version_ = newest.version;
    if (!model.ok()) return model.status();
    spdlog::info("database '{}': model {} loaded{}", name, newest.version,
                 is_extension ? " as an extension" : "");
    const bool is_extensible = TakesClips(newest.build_seconds);
    Snapshot snapshot{std::move(newest), *std::move(model), Calibration::kOwn, is_extensible};
    if (is_extension) snapshot.has_fitted_labels = before->has_fitted_labels;
    ServedModel read{std::make_shared<const Snapshot>(std::move(snapshot)), 0};
    auto relabelled = Relabelled(read);
    // Corrupt annotations do not keep the model from answering.
    if (absl::IsDataLoss(relabelled.status())) return read;
    return relabelled;
  }
}

absl::StatusOr<bool> ModelLifecycle::IsCurrent(const Snapshot& snapshot) {
  if (!is_shared()) return true;
  MOTIONDB_ASSIGN_OR_RETURN(const auto newest, services_.store.ListModels(database_.name(), 0, 1));
  return !newest.empty() && newest.front().current &&
         newest.front().version == snapshot.record.version;
}

void ModelLifecycle::RequestMissedBuild() {
  const auto checked = [&]() -> absl::StatusOr<bool> {
    MOTIONDB_ASSIGN_OR_RETURN(const auto newest,
                              services_.store.ListOperations(database_.name(), "", 1));
    {
      const MutexLock lock(mutex_);
      const auto* const last = newest.empty() ? nullptr : &newest.front();
      if (!missed_build_.MayRequest(last, database_.seen_revision())) return false;
    }
    return RebuildIfOutdated();
  }();
  const MutexLock lock(mutex_);
  missed_build_.Checked(checked);
}

bool ModelLifecycle::EndUnfinished(Build& build, const absl::Status& built) {
  if (!is_shared() || built.ok()) return false;
  const StopReason stop = build.stop;
  // The served model may be that of this build, which was not stored.
  const auto read_again = [&] {
    stored_version_ = -1;
    const MutexLock lock(mutex_);
    ScheduleUpdate();
  };
  if (build.is_fenced() && stop != StopReason::kForgotten) {
    spdlog::warn("database '{}': another server has taken over operation {}", database_.name(),
                 build.operation);
    ++lost_leases_;
    services_.operations.HandOver(build.operation);
    read_again();
    return true;
  }
  // It has not begun, and may run on another server.
  if (stop == StopReason::kShutdown && build.lease == nullptr) return true;
  if (stop != StopReason::kNone) return false;
  const bool has_no_lease = build.lease == nullptr && absl::IsAborted(built);
  const bool is_newer = storage::IsNewerFormat(built);
  if (!has_no_lease && !is_newer && !absl::IsUnavailable(built)) return false;
  if (is_newer && !newer_logged_.exchange(true)) {
    spdlog::warn("database '{}': not built by this server: {}", database_.name(),
                 std::string(built.message()));
  }
  if (absl::IsUnavailable(built)) {
    spdlog::warn("database '{}': build waits for the store: {}", database_.name(),
                 std::string(built.message()));
    // Another server may run it, and find nothing left to build.
    if (const auto model = snapshot(); model != nullptr && !model->is_stored()) read_again();
  }
  if (build.lease != nullptr) services_.operations.Postpone(build.operation);
  build.is_deferred = true;
  build.is_newer = is_newer;
  return true;
}

void ModelLifecycle::Follow(const std::vector<std::string>& unfinished, bool is_changed) {
  const auto is_unfinished = [&](const std::string& operation) {
    return std::ranges::find(unfinished, operation) != unfinished.end();
  };
  std::vector<std::string> missing;
  {
    const MutexLock lock(mutex_);
    if (is_closed_) return;
    for (const std::string& operation : unfinished) {
      const bool is_known = (running_ != nullptr && running_->operation == operation) ||
                            std::ranges::count(waiting_, operation, &Waiting::operation) > 0;
      if (!is_known) Enqueue({operation, /*is_foreign=*/true});
    }
    for (const Waiting& waiting : waiting_) {
      if (!is_unfinished(waiting.operation)) missing.push_back(waiting.operation);
    }
    if (running_ != nullptr && !is_unfinished(running_->operation)) {
      missing.push_back(running_->operation);
    }
    if (is_changed && std::ranges::all_of(waiting_, &Waiting::is_foreign)) {
      last_request_ = services_.executor.Now();
      ArmBuild();
    }
    if (is_changed && std::exchange(awaits_change_, false)) {
      not_before_ = services_.executor.Now();
      ArmBuild();
    }
    if (is_changed) ScheduleUpdate();
    const bool is_busy = !unfinished.empty() || state() != State::kIdle || is_storing_request_ ||
                         ingests_ > 0 || update_pending_ || is_updating_;
    const bool is_due = missed_build_.IsDue(services_.executor.Now(), is_changed, is_busy);
    if (is_due && services_.options.builds()) {
      services_.executor.Post(Pool::kExtensions, KeepAlive(&ModelLifecycle::RequestMissedBuild));
    }
  }
  for (const std::string& operation : missing) {
    // The list may be older than the operation. The registry also has those that could not be
    // stored.
    const auto known = services_.operations.Get(operation);
    const auto stored = services_.store.GetOperation(operation);
    const MutexLock lock(mutex_);
    if (running_ != nullptr && running_->operation == operation) {
      if (!stored.ok() || stored->state != storage::OperationState::kCancelled) continue;
      StopReason none = StopReason::kNone;
      running_->stop.compare_exchange_strong(none, StopReason::kCancelled);
    } else if (known.ok() ? known->done() : absl::IsNotFound(known.status())) {
      Remove(operation);
    }
  }
}

}  // namespace motiondb::server
