// Waiting for a mutex no longer than somebody wants what it guards. Safe to call from any thread.
#pragma once

#include <chrono>
#include <mutex>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"

namespace motiondb::storage {

#ifdef __SANITIZE_THREAD__
using WaitClock = std::chrono::system_clock;  // of waits by the steady one GCC 12's knows nothing
#else
using WaitClock = std::chrono::steady_clock;
#endif

// When a waiting thread next asks whether it is cancelled.
inline WaitClock::time_point NextQuestion() {
  return WaitClock::now() + std::chrono::milliseconds(20);
}

inline absl::Status NotWanted() {
  return absl::CancelledError("what was asked for was no longer wanted when its turn came");
}

// CANCELLED, without the mutex, soon after `cancelled` says so.
inline absl::Status Lock(std::unique_lock<std::timed_mutex>& lock,
                         const core::Cancelled& cancelled) {
  if (!cancelled) {
    lock.lock();
    return absl::OkStatus();
  }
  while (!cancelled()) {
    if (lock.try_lock_until(NextQuestion())) return absl::OkStatus();
  }
  return NotWanted();
}

}  // namespace motiondb::storage
