// Takes the place of storage/mutex.h in the simulation: locks and waits of tasks.
#pragma once

#include <chrono>

#include "absl/base/thread_annotations.h"
#include "core/motion/execution.h"
#include "tests/simulation/world.h"

namespace motiondb::storage {

class ABSL_LOCKABLE Mutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.Lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.Unlock(); }
  bool try_lock() ABSL_EXCLUSIVE_TRYLOCK_FUNCTION(true) { return mutex_.TryLock(); }
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}

 private:
  simulation::TaskMutex mutex_;
};

template <typename Lockable>
class ABSL_SCOPED_LOCKABLE MutexLock {
 public:
  explicit MutexLock(Lockable& mutex) ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) : mutex_(mutex) {
    mutex_.lock();
  }
  ~MutexLock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Lockable& mutex_;
};

class ConditionVariable {
 public:
  void NotifyOne() { waiting_.WakeOne(); }
  void NotifyAll() { waiting_.WakeAll(); }

  template <typename Condition>
  void Wait(Mutex& mutex, const Condition& condition) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    WaitOrCancel(mutex, {}, condition);
  }
  template <typename Condition>
  bool WaitOrCancel(Mutex& mutex, const core::Cancelled& cancelled, const Condition& condition)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    while (!condition()) {
      if (cancelled && cancelled()) return false;
      mutex.unlock();
      if (cancelled) {
        waiting_.WaitUntil(simulation::World::Current().now() + std::chrono::milliseconds(20));
      } else {
        waiting_.Wait();
      }
      mutex.lock();
    }
    return true;
  }

 private:
  simulation::WaitList waiting_;
};

}  // namespace motiondb::storage
