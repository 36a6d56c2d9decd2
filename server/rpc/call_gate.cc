#include "server/rpc/call_gate.h"

namespace motiondb::server {

void CallGate::Close() {
  // Under the lock, which a ticket must take to leave: no call ends before it was told.
  const std::lock_guard lock(mutex_);
  closed_ = true;
  for (const Ticket* const ticket : calls_) {
    if (ticket->on_close_) ticket->on_close_();
  }
}

void CallGate::AwaitEmpty(Clock::time_point latest) {
  std::unique_lock lock(mutex_);
  empty_.wait_until(lock, latest, [this] { return calls_.empty(); });
}

void CallGate::CancelEndedBefore(Clock::time_point time) {
  // Under the lock, as in Close.
  const std::lock_guard lock(mutex_);
  for (const Ticket* const ticket : calls_) {
    if (ticket->cancel_ && ticket->ended_.load() < time) ticket->cancel_();
  }
}

bool CallGate::Enter(const Ticket& ticket) {
  const std::lock_guard lock(mutex_);
  if (closed_) return false;
  calls_.insert(&ticket);
  return true;
}

void CallGate::Leave(const Ticket& ticket) {
  const std::lock_guard lock(mutex_);
  calls_.erase(&ticket);
  if (calls_.empty()) empty_.notify_all();
}

}  // namespace motiondb::server
