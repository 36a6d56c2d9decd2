// std::mutex with annotations for clang's -Wthread-safety. absl::Mutex has them too, but the thread
// sanitizer cannot instrument Debian's build of it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <shared_mutex>

#include "absl/base/thread_annotations.h"
#include "core/motion/execution.h"

namespace motiondb::storage {

class ABSL_LOCKABLE Mutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  bool try_lock() ABSL_EXCLUSIVE_TRYLOCK_FUNCTION(true) { return mutex_.try_lock(); }
  // Tells the static analysis that the mutex is held, for example in the condition of a wait.
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}

 private:
  std::mutex mutex_;
};

// The thread that holds it may lock it again.
class ABSL_LOCKABLE RecursiveMutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }

 private:
  std::recursive_mutex mutex_;
};

// Held by one writer or by several readers.
class ABSL_LOCKABLE SharedMutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  void lock_shared() ABSL_SHARED_LOCK_FUNCTION() { mutex_.lock_shared(); }
  void unlock_shared() ABSL_UNLOCK_FUNCTION() { mutex_.unlock_shared(); }

 private:
  std::shared_mutex mutex_;
};

// Holds a mutex exclusively during its lifetime.
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

// Holds a mutex shared with other readers during its lifetime.
class ABSL_SCOPED_LOCKABLE ReadLock {
 public:
  explicit ReadLock(SharedMutex& mutex) ABSL_SHARED_LOCK_FUNCTION(mutex) : mutex_(mutex) {
    mutex_.lock_shared();
  }
  ~ReadLock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock_shared(); }
  ReadLock(const ReadLock&) = delete;
  ReadLock& operator=(const ReadLock&) = delete;

 private:
  SharedMutex& mutex_;
};

#ifdef __SANITIZE_THREAD__
using WaitClock = std::chrono::system_clock;  // GCC 12's tsan does not see steady_clock waits
#else
using WaitClock = std::chrono::steady_clock;
#endif

// Returns when a waiting thread polls its cancellation next.
inline WaitClock::time_point NextPollTime() {
  return WaitClock::now() + std::chrono::milliseconds(20);
}

// Waits for a condition. `condition` is called with the mutex held.
class ConditionVariable {
 public:
  void NotifyOne() { changed_.notify_one(); }
  void NotifyAll() { changed_.notify_all(); }

  template <typename Condition>
  void Wait(Mutex& mutex, const Condition& condition) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    changed_.wait(mutex, condition);
  }
  // Returns false if the condition is still false at `end`.
  template <typename Condition>
  bool WaitUntil(Mutex& mutex, WaitClock::time_point end, const Condition& condition)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    return changed_.wait_until(mutex, end, condition);
  }
  // Returns false if `cancelled` returns true before the condition does. `cancelled` is called with
  // the mutex held: immediately, and then every 20 ms. If it is empty, the wait is unlimited.
  template <typename Condition>
  bool WaitOrCancel(Mutex& mutex, const core::Cancelled& cancelled, const Condition& condition)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    if (!cancelled) changed_.wait(mutex, condition);
    while (!condition()) {
      if (cancelled()) return false;
      changed_.wait_until(mutex, NextPollTime(), condition);
    }
    return true;
  }

 private:
  std::condition_variable_any changed_;
};

}  // namespace motiondb::storage
