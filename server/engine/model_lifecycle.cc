#include "server/engine/model_lifecycle.h"

#include <algorithm>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/engine/live_database.h"
#include "server/engine/work/clock.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/operation_registry.h"
#include "storage/cancellable_lock.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;
using storage::MutexLock;

// Extensions use at most 1 / (1 + kPauseFactor) of a thread: the pause after an extension is
// kPauseFactor times its duration.
constexpr int kPauseFactor = 3;
constexpr milliseconds kMinPause{50};
constexpr milliseconds kMaxPause{500};  // so that a clip is in the model within a second

// Operations of other servers wait longer: those servers see each ingest, this one only polls.
constexpr milliseconds kForeignDelay{2000};
// Time until a build that did not get its lease, or a build or update that did not reach the store,
// is tried again.
constexpr milliseconds kDeferral{1000};
// Servers that look at the store at the same moment request a missed build at different ones.
constexpr int kSpreadMilliseconds = 2000;

}  // namespace

ModelLifecycle::ModelLifecycle(LiveDatabase& database, const LifecycleServices& services)
    : database_(database),
      services_(services),
      missed_build_(milliseconds(NowMicroseconds() % kSpreadMilliseconds)),
      due_(services.executor.MakeTimer(Pool::kBuilds)),
      retry_(services.executor.MakeTimer(Pool::kBuilds)),
      update_due_(services.executor.MakeTimer(Pool::kExtensions)) {}

ModelLifecycle::State ModelLifecycle::state() const {
  if (is_closed_) return State::kClosed;
  if (running_ != nullptr) return State::kBuilding;
  return waiting_.empty() ? State::kIdle : State::kWaiting;
}

std::string ModelLifecycle::operation() const {
  const MutexLock lock(mutex_);
  if (running_ != nullptr) return running_->operation;
  return waiting_.empty() ? "" : waiting_.front().operation;
}

Executor::Clock::time_point ModelLifecycle::DueTime() const {
  const auto latest = std::max(not_before_, first_request_ + services_.options.rebuild_delay_limit);
  if (ingests_ > 0) return latest;
  const milliseconds delay = std::ranges::all_of(waiting_, &Waiting::is_foreign)
                                 ? services_.options.rebuild_delay + kForeignDelay
                                 : services_.options.rebuild_delay;
  return std::max(not_before_, std::min(latest, last_request_ + delay));
}

Executor::Work ModelLifecycle::KeepAlive(void (ModelLifecycle::*work)()) {
  return [weak = database_.weak_from_this(), work] {
    if (const auto alive = weak.lock()) (alive->lifecycle().*work)();
  };
}

absl::StatusOr<storage::OperationRecord> ModelLifecycle::Request(const core::Cancelled& cancelled) {
  auto operation = RequestStored(storage::OperationKind::kRebuild, cancelled);
  // The change that needs the build is already stored.
  if (absl::IsCancelled(operation.status())) {
    services_.executor.Post(Pool::kBuilds, KeepAlive(&ModelLifecycle::RequestInBackground));
  }
  return operation;
}

absl::StatusOr<storage::OperationRecord> ModelLifecycle::RequestReprocess(
    const core::Cancelled& cancelled) {
  return RequestStored(storage::OperationKind::kReprocess, cancelled);
}

void ModelLifecycle::RequestInBackground() {
  database_.WithSharedUse(DeletionPolicy::kAwait, [&] { return Request().status(); })
      .IgnoreError();  // if the database was deleted, there is nothing to rebuild
}

absl::StatusOr<storage::OperationRecord> ModelLifecycle::RequestStored(
    storage::OperationKind kind, const core::Cancelled& cancelled) {
  while (true) {
    std::string last;
    if (auto joined = Join(kind, last)) return *std::move(joined);
    const MutexLock lock(mutex_);
    if (!is_storing_request_) {
      // Unless another operation has come meanwhile, which may cover this request.
      if (last != (waiting_.empty() ? "" : waiting_.back().operation)) continue;
      is_storing_request_ = true;
      break;
    }
    const bool stored = changed_.WaitOrCancel(mutex_, cancelled, [this] {
      mutex_.AssertHeld();
      return !is_storing_request_;
    });
    if (!stored) return storage::CancelledInQueue();
  }
  const absl::Cleanup stored = [this] {
    const MutexLock lock(mutex_);
    is_storing_request_ = false;
    changed_.NotifyAll();
  };
  MOTIONDB_ASSIGN_OR_RETURN(auto operation, services_.operations.Create(database_.name(), cancelled,
                                                                        kind, database_.id()));
  const MutexLock lock(mutex_);
  Enqueue({operation.id});
  return operation;
}

std::optional<storage::OperationRecord> ModelLifecycle::Join(storage::OperationKind kind,
                                                             std::string& last) {
  {
    const MutexLock lock(mutex_);
    if (waiting_.empty()) return std::nullopt;
    last = waiting_.back().operation;
  }
  // If a shared store cannot be read, the registry returns an older state.
  auto operation =
      is_shared() ? services_.store.GetOperation(last) : services_.operations.Get(last);
  if (!operation.ok() || operation->state != storage::OperationState::kPending) return std::nullopt;
  const bool only_rebuilds = operation->kind == storage::OperationKind::kRebuild;
  if (only_rebuilds && kind == storage::OperationKind::kReprocess) return std::nullopt;
  const MutexLock lock(mutex_);
  const auto waiting = std::ranges::find(waiting_, last, &Waiting::operation);
  if (waiting == waiting_.end()) return std::nullopt;  // it has begun
  waiting->is_foreign = false;
  last_request_ = services_.executor.Now();
  ArmBuild();
  return *std::move(operation);
}

void ModelLifecycle::Resume(const std::string& operation) {
  const MutexLock lock(mutex_);
  Enqueue({operation});
}

void ModelLifecycle::Enqueue(Waiting waiting) {
  if (waiting_.empty() || !waiting.is_foreign) {
    first_request_ = last_request_ = services_.executor.Now();
  }
  waiting_.push_back(std::move(waiting));
  if (!is_closed_) retry_->Cancel();
  ArmBuild();
}

bool ModelLifecycle::Remove(const std::string& operation) {
  const auto removed = std::erase_if(
      waiting_, [&](const Waiting& waiting) { return waiting.operation == operation; });
  if (removed > 0) ArmBuild();  // the others may be due later
  return removed > 0;
}

void ModelLifecycle::ArmBuild() {
  if (!services_.options.builds()) return;
  if (state() == State::kWaiting && purges_ == 0) {
    due_->Set(DueTime(), KeepAlive(&ModelLifecycle::BuildIfDue));
  }
}

ModelLifecycle::Ingest::Ingest(std::shared_ptr<LiveDatabase> database)
    : database_(std::move(database)) {
  ModelLifecycle& lifecycle = database_->lifecycle();
  const MutexLock lock(lifecycle.mutex_);
  ++lifecycle.ingests_;
  lifecycle.ArmBuild();
}

ModelLifecycle::Ingest::~Ingest() {
  ModelLifecycle& lifecycle = database_->lifecycle();
  const MutexLock lock(lifecycle.mutex_);
  --lifecycle.ingests_;
  lifecycle.last_request_ = lifecycle.services_.executor.Now();
  lifecycle.ArmBuild();
}

absl::StatusOr<bool> ModelLifecycle::Cancel(const std::string& operation,
                                            const core::Cancelled& cancelled) {
  {
    const MutexLock lock(mutex_);
    if (running_ != nullptr && running_->operation == operation) {
      StopReason none = StopReason::kNone;
      return running_->stop.compare_exchange_strong(none, StopReason::kCancelled);
    }
    // Removed from the queue while the cancellation is stored: it neither starts nor joins
    // requests.
    if (!Remove(operation)) return false;
  }
  const absl::Status stored = services_.operations.Cancel(operation, cancelled);
  if (stored.ok()) return true;
  const MutexLock lock(mutex_);
  waiting_.push_front({operation});
  ArmBuild();
  return stored;
}

void ModelLifecycle::PurgeUnlessBuilding(const core::Cancelled& cancelled) {
  {
    const MutexLock lock(mutex_);
    if (running_ != nullptr || is_shared()) return;  // another server may be building
    ++purges_;
  }
  const absl::Cleanup ended = [this] {
    const MutexLock lock(mutex_);
    --purges_;
    ArmBuild();
  };
  PurgeDeletedClips(cancelled);
}

void ModelLifecycle::BuildIfDue() {
  std::shared_ptr<Build> build;
  {
    const MutexLock lock(mutex_);
    // The timer may have fired just before it was set again.
    if (state() != State::kWaiting || purges_ > 0 || services_.executor.Now() < DueTime()) return;
    build = running_ = std::make_shared<Build>();
    build->operation = std::move(waiting_.front().operation);
    waiting_.pop_front();
  }
  const absl::Status ended = RunBuild(*build);
  build->lease = nullptr;                              // releases it, unless an extension uses it
  const absl::Cleanup room = [this] { MakeRoom(0); };  // without the lock
  const MutexLock lock(mutex_);
  running_ = nullptr;
  if (build->is_deferred) {
    waiting_.push_front({build->operation});
    awaits_change_ = build->is_newer;
    not_before_ = services_.executor.Now() +
                  (build->is_newer ? services_.options.rebuild_retry_delay : kDeferral);
  }
  ArmBuild();
  const bool out_of_space = absl::IsResourceExhausted(ended) || absl::IsUnavailable(ended);
  if (out_of_space && !build->is_deferred && !build->stopped() && state() == State::kIdle) {
    retry_->Set(services_.executor.Now() + services_.options.rebuild_retry_delay,
                KeepAlive(&ModelLifecycle::RequestInBackground));
  }
  changed_.NotifyAll();
}

void ModelLifecycle::RequestUpdate() {
  const MutexLock lock(mutex_);
  may_extend_ = true;
  ScheduleUpdate();
}

void ModelLifecycle::ScheduleUpdate() {
  if (is_closed_ || update_pending_) return;
  update_pending_ = true;
  if (!is_updating_) ArmUpdate(Executor::Clock::duration::zero());
}

void ModelLifecycle::ArmUpdate(Executor::Clock::duration rest) {
  update_due_->Set(services_.executor.Now() + rest, KeepAlive(&ModelLifecycle::UpdateIfOpen));
}

void ModelLifecycle::UpdateIfOpen() {
  bool may_extend = false;
  bool is_used = false;
  {
    const MutexLock lock(mutex_);
    if (is_closed_) return;
    update_pending_ = false;
    is_updating_ = true;
    may_extend = std::exchange(may_extend_, false);
    is_used = std::exchange(is_used_, false);
  }
  const auto began = services_.executor.Now();
  const absl::Status updated = UpdateCurrent(may_extend, is_used);
  const absl::Cleanup room = [this] { MakeRoom(0); };  // without the lock
  const MutexLock lock(mutex_);
  is_updating_ = false;
  is_used_ = is_used_ && served_.unloaded != nullptr;
  update_pending_ = update_pending_ || is_used_;
  // No later look would find this change again.
  const bool fails = is_shared() && absl::IsUnavailable(updated);
  if (fails) {
    update_pending_ = true;
    may_extend_ = may_extend_ || may_extend;
  }
  if (update_pending_ && !is_closed_) {
    const Executor::Clock::duration rest = kPauseFactor * (services_.executor.Now() - began);
    ArmUpdate(fails ? kDeferral
                    : std::clamp<Executor::Clock::duration>(rest, kMinPause, kMaxPause));
  }
  changed_.NotifyAll();
}

void ModelLifecycle::Close() {
  is_closed_ = true;
  due_.reset();
  retry_.reset();
  update_due_.reset();
}

void ModelLifecycle::Forget() {
  Serve({});
  const MutexLock lock(mutex_);
  Close();
  for (const Waiting& waiting : std::exchange(waiting_, {})) {
    services_.operations.Abandon(waiting.operation);
  }
  if (running_ != nullptr) running_->stop = StopReason::kForgotten;
}

void ModelLifecycle::BeginStop() {
  const MutexLock lock(mutex_);
  Close();
  if (running_ == nullptr) return;
  StopReason none = StopReason::kNone;
  running_->stop.compare_exchange_strong(none, StopReason::kShutdown);
}

void ModelLifecycle::AwaitStop() {
  const MutexLock lock(mutex_);
  changed_.Wait(mutex_, [this] {
    mutex_.AssertHeld();
    return running_ == nullptr && !is_updating_;
  });
}

absl::StatusOr<bool> ModelLifecycle::IsUpToDate() {
  const ServedModel current = served();
  if (current.unloaded != nullptr) return HasAllClips(*current.unloaded);
  if (current.snapshot == nullptr) return database_.stored().clip_count == 0;
  if (!current.snapshot->has_fitted_labels) return false;
  return HasAllClips(*current.snapshot);
}

}  // namespace motiondb::server
