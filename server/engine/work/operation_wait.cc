#include "server/engine/work/operation_wait.h"

#include <utility>

namespace motiondb::server {

std::shared_ptr<OperationWait> OperationWait::Start(Executor& executor, OperationRegistry& registry,
                                                    std::string id,
                                                    Executor::Clock::duration timeout, Done done) {
  std::shared_ptr<OperationWait> wait(
      new OperationWait(executor, registry, std::move(id), std::move(done)));
  executor.Post(Pool::kRequests, [wait, timeout] { wait->Begin(timeout); });
  return wait;
}

OperationWait::OperationWait(Executor& executor, OperationRegistry& registry, std::string id,
                             Done done)
    : executor_(executor),
      registry_(registry),
      id_(std::move(id)),
      timer_(executor.MakeTimer(Pool::kRequests)),
      done_(std::move(done)) {}

void OperationWait::Stop() {
  executor_.Post(Pool::kRequests,
                 [self = shared_from_this()] { self->End(self->registry_.Get(self->id_)); });
}

void OperationWait::Begin(Executor::Clock::duration timeout) {
  {
    const storage::MutexLock lock(mutex_);
    if (!done_) return;  // stopped before it began
    // The registry has only a weak reference: a wait that has ended is freed before its operation
    // ends.
    watch_ =
        registry_.Watch(id_, [weak = weak_from_this()](const storage::OperationRecord& record) {
          const auto self = weak.lock();
          if (!self) return;
          self->executor_.Post(Pool::kRequests, [self, record] { self->End(record); });
        });
    if (watch_ != 0) {
      timer_->Set(executor_.Now() + timeout,
                  [self = shared_from_this()] { self->End(self->registry_.Get(self->id_)); });
      return;
    }
  }
  End(registry_.Get(id_));
}

void OperationWait::End(absl::StatusOr<storage::OperationRecord> record) {
  Done done;
  {
    const storage::MutexLock lock(mutex_);
    if (!done_) return;
    registry_.Unwatch(id_, watch_);
    timer_->Cancel();
    done = std::exchange(done_, nullptr);
  }
  done(std::move(record));
}

}  // namespace motiondb::server
