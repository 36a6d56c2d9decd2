// Threads and clock of the engine. All asynchronous and delayed work of the engine goes through
// this interface, so that a simulation can replace time and scheduling.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "core/motion/execution.h"

namespace motiondb::server {

// Thread pools.
enum class Pool {
  kRequests,     // queries and short work
  kBuilds,       // models
  kExtensions,   // extensions of models, also while other models are built
  kChanges,      // changes of the store: they may wait for its writer; queries do not wait for them
  kMaintenance,  // maintenance of the whole store; nothing waits for it
  kImports,      // waits for processes that read files: no thread of requests waits for them
};

class Executor {
 public:
  using Clock = std::chrono::steady_clock;
  using Work = std::function<void()>;

  // Runs work once, at a given time. Not thread-safe: callers need a lock. The destructor cancels.
  class Timer {
   public:
    virtual ~Timer() = default;
    // Replaces the time and work of an earlier Set.
    virtual void Set(Clock::time_point time, Work work) = 0;
    // Work that is about to begin may still run.
    virtual void Cancel() = 0;
  };

  virtual ~Executor() = default;

  virtual Clock::time_point Now() const = 0;
  // Runs `work` once on a thread of the pool. It must not throw.
  virtual void Post(Pool pool, Work work) = 0;
  // Returns a timer whose work runs on a thread of the pool, never within Set.
  virtual std::unique_ptr<Timer> MakeTimer(Pool pool) = 0;
  // Lends the threads of a pool. The calling thread also works, so a loop ends even if all other
  // threads are busy. Loops may be nested.
  virtual core::ParallelFor Parallel(Pool pool) = 0;
};

}  // namespace motiondb::server
