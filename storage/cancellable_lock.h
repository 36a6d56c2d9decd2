// Waiting for a mutex no longer than somebody wants what it guards. Safe to call from any thread.
#pragma once

#include <mutex>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/mutex.h"

namespace motiondb::storage {

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
