// A mutex and a semaphore that may be held for long. Waiting for them can be cancelled.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/mutex.h"

namespace motiondb::storage {

inline absl::Status CancelledInQueue() {
  return absl::CancelledError("the request was cancelled while it waited in the queue");
}

class CancellableSemaphore {
 public:
  struct Unlock {
    void operator()(CancellableSemaphore* semaphore) const { semaphore->Release(); }
  };
  // Releases one place on destruction. Null: holds none.
  using Holder = std::unique_ptr<CancellableSemaphore, Unlock>;

  // `places`: maximum number of holders, at least 1.
  explicit CancellableSemaphore(int places) : free_(places) {}

  // Waits for a place. Returns CANCELLED within about 20 ms after `cancelled` returns true.
  absl::StatusOr<Holder> Lock(const core::Cancelled& cancelled) {
    const MutexLock lock(mutex_);
    const bool is_free = released_.WaitOrCancel(mutex_, cancelled, [this] {
      mutex_.AssertHeld();
      return free_ > 0;
    });
    if (!is_free) return CancelledInQueue();
    --free_;
    return Holder(this);
  }

 private:
  void Release() {
    const MutexLock lock(mutex_);
    ++free_;
    released_.NotifyOne();
  }

  Mutex mutex_;
  ConditionVariable released_;
  int free_ ABSL_GUARDED_BY(mutex_);
};

class CancellableMutex : public CancellableSemaphore {
 public:
  CancellableMutex() : CancellableSemaphore(1) {}
};

}  // namespace motiondb::storage
