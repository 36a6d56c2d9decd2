#include "server/rpc/call_gate.h"

namespace motiondb::server {

void CallGate::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

void CallGate::AwaitEmpty(std::chrono::steady_clock::time_point latest) {
  std::unique_lock lock(mutex_);
  empty_.wait_until(lock, latest, [this] { return calls_ == 0; });
}

bool CallGate::Enter() {
  const std::lock_guard lock(mutex_);
  if (closed_) return false;
  ++calls_;
  return true;
}

void CallGate::Leave() {
  const std::lock_guard lock(mutex_);
  if (--calls_ == 0) empty_.notify_all();
}

}  // namespace motiondb::server
