// Waiting for a mutex no longer than somebody wants what it guards. Safe to call from any thread.
#pragma once

#include <chrono>
#include <mutex>

#include "core/motion/cancellation.h"

namespace motiondb::storage {

// False, without the mutex, soon after `cancelled` says so.
inline bool Lock(std::unique_lock<std::timed_mutex>& lock, const core::Cancelled& cancelled) {
  constexpr std::chrono::milliseconds kBetweenQuestions{20};
  if (!cancelled) {
    lock.lock();
    return true;
  }
  // The system's clock, though it may be set: of the steady one's wait GCC 12's thread sanitizer
  // knows nothing.
  while (!cancelled()) {
    if (lock.try_lock_until(std::chrono::system_clock::now() + kBetweenQuestions)) return true;
  }
  return false;
}

}  // namespace motiondb::storage
