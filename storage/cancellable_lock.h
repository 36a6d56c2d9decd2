// A mutex that is held for long, and waited for no longer than somebody wants what it guards.
// Thread-safe.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "storage/mutex.h"

namespace motiondb::storage {

inline absl::Status NotWanted() {
  return absl::CancelledError("what was asked for was no longer wanted when its turn came");
}

class CancellableMutex {
 public:
  struct Unlock {
    void operator()(CancellableMutex* mutex) const { mutex->Release(); }
  };
  // Holds the mutex while it lives. Null: holds none.
  using Holder = std::unique_ptr<CancellableMutex, Unlock>;

  // CANCELLED, without the mutex, soon after `cancelled` says so.
  absl::StatusOr<Holder> Lock(const core::Cancelled& cancelled) {
    const MutexLock lock(mutex_);
    const bool is_free = released_.WaitUnless(mutex_, cancelled, [this] {
      mutex_.AssertHeld();
      return !is_held_;
    });
    if (!is_free) return NotWanted();
    is_held_ = true;
    return Holder(this);
  }

 private:
  void Release() {
    const MutexLock lock(mutex_);
    is_held_ = false;
    released_.NotifyOne();
  }

  Mutex mutex_;
  ConditionVariable released_;
  bool is_held_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::storage
