#include "server/rpc/call_registry.h"

namespace motiondb::server {

void CallRegistry::Close() {
  // A call needs this lock to leave, so no call is destroyed during its callback.
  const storage::MutexLock lock(mutex_);
  closed_ = true;
  for (const RegisteredCall* const call : calls_) {
    if (call->on_close_) call->on_close_();
  }
}

void CallRegistry::AwaitEmpty(Clock::time_point latest) {
  const storage::MutexLock lock(mutex_);
  empty_.WaitUntil(mutex_, storage::WaitClock::now() + (latest - Clock::now()), [this] {
    mutex_.AssertHeld();
    return calls_.empty();
  });
}

void CallRegistry::CancelEndedBefore(Clock::time_point time) {
  // With the lock, as in Close.
  const storage::MutexLock lock(mutex_);
  for (const RegisteredCall* const call : calls_) {
    if (call->cancel_ && call->ended_.load() < time) call->cancel_();
  }
}

bool CallRegistry::Enter(const RegisteredCall& call) {
  const storage::MutexLock lock(mutex_);
  if (closed_) return false;
  calls_.insert(&call);
  return true;
}

void CallRegistry::Leave(const RegisteredCall& call) {
  const storage::MutexLock lock(mutex_);
  calls_.erase(&call);
  if (calls_.empty()) empty_.NotifyAll();
}

}  // namespace motiondb::server
