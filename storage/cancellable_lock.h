// A mutex that may be held for long. Waiting for it can be cancelled.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "storage/mutex.h"

namespace motiondb::storage {

inline absl::Status CancelledInQueue() {
  return absl::CancelledError("the request was cancelled while it waited in the queue");
}

class CancellableMutex {
 public:
  struct Unlock {
    void operator()(CancellableMutex* mutex) const { mutex->Release(); }
  };
  // Releases the mutex on destruction. Null: holds no mutex.
  using Holder = std::unique_ptr<CancellableMutex, Unlock>;

  // Waits for the mutex. Returns CANCELLED within about 20 ms after `cancelled` returns true.
  absl::StatusOr<Holder> Lock(const core::Cancelled& cancelled) {
    const MutexLock lock(mutex_);
    const bool is_free = released_.WaitOrCancel(mutex_, cancelled, [this] {
      mutex_.AssertHeld();
      return !is_held_;
    });
    if (!is_free) return CancelledInQueue();
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
