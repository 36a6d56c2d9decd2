// What a ModelLifecycle does because several servers share the store.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operation_registry.h"
#include "server/engine/options.h"

namespace motiondb::server {

using storage::MutexLock;

absl::StatusOr<ModelLifecycle::Lease> ModelLifecycle::AcquireLease() {
  if (!is_shared()) return Lease();
  const MutexLock lock(lease_mutex_);
  if (auto held = lease_.lock(); held != nullptr && !held->is_lost()) return held;
  MOTIONDB_ASSIGN_OR_RETURN(
      Lease acquired,
      BuildLease::Acquire(services_.store, services_.executor, database_.name(), services_.holder));
  lease_ = acquired;
  return acquired;
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

absl::StatusOr<ServedModel> ModelLifecycle::Followed(ServedModel served) {
  if (!is_shared()) return served;
  const std::string& name = database_.name();
  MOTIONDB_ASSIGN_OR_RETURN(auto newest, services_.store.ListModels(name, 0, 1));
  const bool has_model = !newest.empty() && newest.front().current;
  if ((has_model ? newest.front().version : 0) == stored_version_) return served;
  if (has_model) return ReadNewer(served, std::move(newest.front()));
  stored_version_ = 0;
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, database_.Catalog(services_.store.annotations()));
  return ServedModel{nullptr, catalog->clip_count() == 0 ? catalog->revision() : 0};
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
    if (again.empty() || !again.front().current) return Followed(served);  // it was dropped
    if (again.front().version != newest.version) {
      newest = std::move(again.front());
      continue;
    }
    // A corrupt model is not read again; a build replaces it.
    if (model.ok() || absl::IsDataLoss(model.status())) stored_version_ = newest.version;
    if (!model.ok()) return model.status();
    spdlog::info("database '{}': model {} loaded{}", name, newest.version,
                 is_extension ? " as an extension" : "");
    const bool is_extensible = newest.build_seconds >= services_.options.extend_from.count();
    Snapshot snapshot{std::move(newest), *std::move(model), Calibration::kOwn, is_extensible};
    if (is_extension) snapshot.has_fitted_labels = before->has_fitted_labels;
    return Relabelled({std::make_shared<const Snapshot>(std::move(snapshot)), 0});
  }
}

void ModelLifecycle::CountStored() {
  const auto catalog = database_.Catalog(services_.store.annotations());
  if (!catalog.ok()) return;
  StoredAmount amount;
  (*catalog)->ForEach([&](const CatalogClip& clip) {
    amount = amount + StoredAmount{1, clip.frame_count, clip.byte_count};
    return true;
  });
  database_.set_stored(amount);
}

bool ModelLifecycle::EndUnfinished(Build& build, const absl::Status& built) {
  if (!is_shared() || built.ok()) return false;
  const StopReason stop = build.stop;
  if (build.is_fenced() && stop != StopReason::kForgotten) {
    spdlog::warn("database '{}': another server has taken over operation {}", database_.name(),
                 build.operation);
    services_.operations.HandOver(build.operation);
    stored_version_ = -1;  // the served model may be that of this build
    const MutexLock lock(mutex_);
    ScheduleUpdate();
    return true;
  }
  // It has not begun, and may run on another server.
  if (stop == StopReason::kShutdown && build.lease == nullptr) return true;
  if (stop != StopReason::kNone) return false;
  const bool has_no_lease = build.lease == nullptr && absl::IsAborted(built);
  if (!has_no_lease && !absl::IsUnavailable(built)) return false;
  if (absl::IsUnavailable(built)) {
    spdlog::warn("database '{}': build waits for the store: {}", database_.name(),
                 std::string(built.message()));
  }
  if (build.lease != nullptr) services_.operations.Postpone(build.operation);
  build.is_deferred = true;
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
    if (is_changed) ScheduleUpdate();
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
