// Waiting for a mutex no longer than somebody wants what it guards. Safe to call from any thread.
#pragma once

#include <chrono>
#include <mutex>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"

namespace motiondb::storage {

// CANCELLED, without the mutex, soon after `cancelled` says so.
inline absl::Status Lock(std::unique_lock<std::timed_mutex>& lock,
                         const core::Cancelled& cancelled) {
  constexpr std::chrono::milliseconds kBetweenQuestions{20};
  if (!cancelled) {
    lock.lock();
    return absl::OkStatus();
  }
#ifdef __SANITIZE_THREAD__
  using Clock = std::chrono::system_clock;  // of waits by the steady one GCC 12's knows nothing
#else
  using Clock = std::chrono::steady_clock;
#endif
  while (!cancelled()) {
    if (lock.try_lock_until(Clock::now() + kBetweenQuestions)) return absl::OkStatus();
  }
  return absl::CancelledError("what was asked for was no longer wanted when its turn came");
}

}  // namespace motiondb::storage
