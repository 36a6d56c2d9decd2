// std::mutex with the annotations that clang checks (-Wthread-safety). absl::Mutex has them too,
// but the thread sanitizer does not see into Debian's build of it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <shared_mutex>

#include "absl/base/thread_annotations.h"
#include "core/motion/cancellation.h"

namespace motiondb::storage {

class ABSL_LOCKABLE Mutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  bool try_lock() ABSL_EXCLUSIVE_TRYLOCK_FUNCTION(true) { return mutex_.try_lock(); }
  // Tells the check that the mutex is held: in the condition of a wait, say.
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}

 private:
  std::mutex mutex_;
};

// A thread that holds it may lock it once more.
class ABSL_LOCKABLE RecursiveMutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }

 private:
  std::recursive_mutex mutex_;
};

// Held by one who changes what it guards, or by several who read it.
class ABSL_LOCKABLE SharedMutex {
 public:
  void lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  void lock_shared() ABSL_SHARED_LOCK_FUNCTION() { mutex_.lock_shared(); }
  void unlock_shared() ABSL_UNLOCK_FUNCTION() { mutex_.unlock_shared(); }

 private:
  std::shared_mutex mutex_;
};

// Holds a mutex while it lives, alone.
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

// Holds a mutex while it lives, beside others who read.
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
using WaitClock = std::chrono::system_clock;  // of waits by the steady one GCC 12's knows nothing
#else
using WaitClock = std::chrono::steady_clock;
#endif

// When a waiting thread next asks whether it is cancelled.
inline WaitClock::time_point NextQuestion() {
  return WaitClock::now() + std::chrono::milliseconds(20);
}

// What threads wait for, under a mutex: `condition` is called with it held.
class ConditionVariable {
 public:
  void NotifyOne() { changed_.notify_one(); }
  void NotifyAll() { changed_.notify_all(); }

  template <typename Condition>
  void Wait(Mutex& mutex, const Condition& condition) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    changed_.wait(mutex, condition);
  }
  // False where the condition does not hold by then.
  template <typename Condition>
  bool WaitUntil(Mutex& mutex, WaitClock::time_point end, const Condition& condition)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    return changed_.wait_until(mutex, end, condition);
  }
  // False if `cancelled`, which is called with the mutex held, says so before the condition holds:
  // it is asked first, and then every 20 ms. Where it is empty, this waits as long as it takes.
  template <typename Condition>
  bool WaitUnless(Mutex& mutex, const core::Cancelled& cancelled, const Condition& condition)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    if (!cancelled) changed_.wait(mutex, condition);
    while (!condition()) {
      if (cancelled()) return false;
      changed_.wait_until(mutex, NextQuestion(), condition);
    }
    return true;
  }

 private:
  std::condition_variable_any changed_;
};

}  // namespace motiondb::storage
