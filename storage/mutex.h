// std::mutex with the annotations that clang checks (-Wthread-safety). absl::Mutex has them too,
// but the thread sanitizer does not see into Debian's build of it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "absl/base/thread_annotations.h"

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

// Holds a mutex while it lives.
class ABSL_SCOPED_LOCKABLE MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) : mutex_(mutex) {
    mutex_.lock();
  }
  ~MutexLock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mutex_;
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

 private:
  std::condition_variable_any changed_;
};

}  // namespace motiondb::storage
