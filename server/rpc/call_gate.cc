#include "server/rpc/call_gate.h"

namespace motiondb::server {

void CallGate::Close() {
  // A ticket needs this lock to leave, so no call is destroyed during its callback.
  const storage::MutexLock lock(mutex_);
  closed_ = true;
  for (const Ticket* const ticket : calls_) {
    if (ticket->on_close_) ticket->on_close_();
  }
}

void CallGate::AwaitEmpty(Clock::time_point latest) {
  const storage::MutexLock lock(mutex_);
  empty_.WaitUntil(mutex_, storage::WaitClock::now() + (latest - Clock::now()), [this] {
    mutex_.AssertHeld();
    return calls_.empty();
  });
}

void CallGate::CancelEndedBefore(Clock::time_point time) {
  // With the lock, as in Close.
  const storage::MutexLock lock(mutex_);
  for (const Ticket* const ticket : calls_) {
    if (ticket->cancel_ && ticket->ended_.load() < time) ticket->cancel_();
  }
}

bool CallGate::Enter(const Ticket& ticket) {
  const storage::MutexLock lock(mutex_);
  if (closed_) return false;
  calls_.insert(&ticket);
  return true;
}

void CallGate::Leave(const Ticket& ticket) {
  const storage::MutexLock lock(mutex_);
  calls_.erase(&ticket);
  if (calls_.empty()) empty_.NotifyAll();
}

}  // namespace motiondb::server
