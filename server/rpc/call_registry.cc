#include "server/rpc/call_registry.h"

namespace motiondb::server {

void CallRegistry::Close() {
  // A ticket needs this lock to leave, so no call is destroyed during its callback.
  const storage::MutexLock lock(mutex_);
  closed_ = true;
  for (const RegisteredCall* const ticket : calls_) {
    if (ticket->on_close_) ticket->on_close_();
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
  for (const RegisteredCall* const ticket : calls_) {
    if (ticket->cancel_ && ticket->ended_.load() < time) ticket->cancel_();
  }
}

bool CallRegistry::Enter(const RegisteredCall& ticket) {
  const storage::MutexLock lock(mutex_);
  if (closed_) return false;
  calls_.insert(&ticket);
  return true;
}

void CallRegistry::Leave(const RegisteredCall& ticket) {
  const storage::MutexLock lock(mutex_);
  calls_.erase(&ticket);
  if (calls_.empty()) empty_.NotifyAll();
}

}  // namespace motiondb::server
