// What the engine runs on: threads and a clock. Whatever it does elsewhere or later goes through
// here, so that a simulation can replace time and scheduling. Thread-safe.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "core/tree/parallel.h"

namespace motiondb::server {

// Threads that work can wait for.
enum class Pool {
  kRequests,    // queries, and what is short
  kBuilds,      // models
  kExtensions,  // of models, while others are built
  kChanges,     // of what the store lists: they may wait for its writer, and no query for them
  kUpkeep,      // work on the store as a whole, for which nothing waits
};

class Executor {
 public:
  using Clock = std::chrono::steady_clock;
  using Work = std::function<void()>;

  // Runs work once, at a time. Not thread-safe: guard it. Destroying it cancels.
  class Timer {
   public:
    virtual ~Timer() = default;
    // In place of what it was set to before.
    virtual void Set(Clock::time_point time, Work work) = 0;
    // Work that is about to begin may still.
    virtual void Cancel() = 0;
  };

  virtual ~Executor() = default;

  virtual Clock::time_point Now() const = 0;
  // Runs a piece of work, which must not throw.
  virtual void Post(Pool pool, Work work) = 0;
  // One whose work runs on a pool's threads, never within Set.
  virtual std::unique_ptr<Timer> MakeTimer(Pool pool) = 0;
  // Lends a pool's threads. The calling thread works too, so a loop ends even where every other
  // thread is taken, and loops may be nested.
  virtual core::ParallelFor Parallel(Pool pool) = 0;
};

}  // namespace motiondb::server
