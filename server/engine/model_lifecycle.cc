#include "server/engine/model_lifecycle.h"

#include <algorithm>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/engine/purge.h"
#include "storage/cancellable_lock.h"

namespace motiondb::server {

using storage::MutexLock;

ModelLifecycle::ModelLifecycle(LiveDatabase& database, const LifecycleServices& services)
    : database_(database),
      services_(services),
      due_(services.executor.MakeTimer(Pool::kBuilds)),
      retry_(services.executor.MakeTimer(Pool::kBuilds)),
      extension_due_(services.executor.MakeTimer(Pool::kExtensions)) {}

ModelLifecycle::State ModelLifecycle::state() const {
  if (is_closed_) return State::kClosed;
  if (running_ != nullptr) return State::kBuilding;
  return waiting_.empty() ? State::kIdle : State::kWaiting;
}

Executor::Clock::time_point ModelLifecycle::DueTime() const {
  const auto latest = first_asked_ + services_.options.rebuild_delay_limit;
  if (ingests_ > 0) return latest;
  return std::min(latest, last_asked_ + services_.options.rebuild_delay);
}

Executor::Work ModelLifecycle::Alive(void (ModelLifecycle::*work)()) {
  return [weak = database_.weak_from_this(), work] {
    if (const auto alive = weak.lock()) (alive->lifecycle().*work)();
  };
}

absl::StatusOr<storage::OperationRecord> ModelLifecycle::Request(const core::Cancelled& cancelled) {
  auto operation = RequestStored(cancelled);
  // The change that asks for it was made all the same.
  if (absl::IsCancelled(operation.status())) {
    services_.executor.Post(Pool::kBuilds, Alive(&ModelLifecycle::RequestInBackground));
  }
  return operation;
}

void ModelLifecycle::RequestInBackground() {
  database_.WhileAlive(Retiring::kAwait, [&] { return Request().status(); })
      .IgnoreError();  // where the database was deleted, so was what is to be rebuilt
}

absl::StatusOr<storage::OperationRecord> ModelLifecycle::RequestStored(
    const core::Cancelled& cancelled) {
  {
    const MutexLock lock(mutex_);
    while (true) {
      if (auto joined = Join()) return *std::move(joined);
      if (!is_storing_request_) break;
      if (cancelled && cancelled()) return storage::NotWanted();
      changed_.WaitUntil(mutex_, storage::NextQuestion(), [this] {
        mutex_.AssertHeld();
        return !is_storing_request_;
      });
    }
    is_storing_request_ = true;
  }
  const absl::Cleanup stored = [this] {
    const MutexLock lock(mutex_);
    is_storing_request_ = false;
    changed_.NotifyAll();
  };
  MOTIONDB_ASSIGN_OR_RETURN(auto operation,
                            services_.operations.Create(database_.name(), cancelled));
  const MutexLock lock(mutex_);
  Enqueue(operation.id);
  return operation;
}

std::optional<storage::OperationRecord> ModelLifecycle::Join() {
  if (waiting_.empty()) return std::nullopt;
  auto operation = services_.operations.Get(waiting_.back());
  if (!operation.ok()) return std::nullopt;
  last_asked_ = services_.executor.Now();
  Arm();
  return *std::move(operation);
}

void ModelLifecycle::Resume(const std::string& operation) {
  const MutexLock lock(mutex_);
  Enqueue(operation);
}

void ModelLifecycle::Enqueue(const std::string& operation) {
  waiting_.push_back(operation);
  first_asked_ = last_asked_ = services_.executor.Now();
  if (!is_closed_) retry_->Cancel();
  Arm();
}

void ModelLifecycle::Arm() {
  database_.set_operation(running_ != nullptr ? running_->operation
                          : waiting_.empty()  ? ""
                                              : waiting_.front());
  if (state() == State::kWaiting) due_->Set(DueTime(), Alive(&ModelLifecycle::BeginIfDue));
}

ModelLifecycle::Ingest::Ingest(std::shared_ptr<LiveDatabase> database)
    : database_(std::move(database)) {
  ModelLifecycle& lifecycle = database_->lifecycle();
  const MutexLock lock(lifecycle.mutex_);
  ++lifecycle.ingests_;
  lifecycle.Arm();
}

ModelLifecycle::Ingest::~Ingest() {
  ModelLifecycle& lifecycle = database_->lifecycle();
  const MutexLock lock(lifecycle.mutex_);
  --lifecycle.ingests_;
  lifecycle.last_asked_ = lifecycle.services_.executor.Now();
  lifecycle.Arm();
}

absl::StatusOr<bool> ModelLifecycle::Cancel(const std::string& operation,
                                            const core::Cancelled& cancelled) {
  {
    const MutexLock lock(mutex_);
    if (running_ != nullptr && running_->operation == operation) {
      StopReason none = StopReason::kNone;
      return running_->stop.compare_exchange_strong(none, StopReason::kCancelled);
    }
    // Not in the queue while this is stored: it neither begins nor serves who asks.
    if (std::erase(waiting_, operation) == 0) return false;
    Arm();
  }
  const absl::Status stored = services_.operations.Cancel(operation, cancelled);
  if (stored.ok()) return true;
  const MutexLock lock(mutex_);
  waiting_.push_front(operation);
  Arm();
  return stored;
}

void ModelLifecycle::PurgeUnlessBuilding(const core::Cancelled& cancelled) {
  const std::unique_lock states(database_.states_mutex(), std::try_to_lock);
  if (states) PurgeDeletedClips(services_.store, database_.name(), cancelled);
}

void ModelLifecycle::Close() {
  is_closed_ = true;
  due_.reset();
  retry_.reset();
  extension_due_.reset();
}

void ModelLifecycle::Forget() {
  const MutexLock lock(mutex_);
  Close();
  for (const std::string& operation : std::exchange(waiting_, {})) {
    services_.operations.Abandon(operation);
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
    return running_ == nullptr && !is_extending_;
  });
}

}  // namespace motiondb::server
