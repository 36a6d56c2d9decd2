// The engine's threads: one pool for requests, one for builds, so that a build never takes the last
// core from queries, two threads for changes, one for each import that may run, and one for each
// other pool (executor.h). All have the same priority: with a lower priority, builds would starve
// on a busy machine.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "server/engine/work/concurrency_limiter.h"
#include "server/engine/work/executor.h"
#include "server/engine/work/options.h"
#include "server/engine/work/thread_pool.h"

namespace motiondb::server {

// Queued pieces of work that have not begun, by pool.
struct QueueLengths {
  int requests = 0;
  int heavy_requests = 0;  // also those whose file waits to be imported
  int changes = 0;
  int urgent_changes = 0;
  int maintenance = 0;
};

class Workers : public Executor {
 public:
  // Returns the number of threads that a Workers object with these options starts.
  static int ThreadCount(const EngineOptions& options);

  explicit Workers(const EngineOptions& options);
  ~Workers() override;

  Clock::time_point Now() const override { return Clock::now(); }
  void Post(Pool pool, Work work) override;
  std::unique_ptr<Timer> MakeTimer(Pool pool) override;
  core::ParallelFor Parallel(Pool pool) override;

  // Runs work that takes long or may block, on a thread of the pool. If a pool has several threads,
  // some stay reserved for work of Post. Clients take turns.
  void PostFair(Pool pool, const std::string& client, Work work);
  QueueLengths queued() const;
  // Queued work that has not begun.
  int queued(Pool pool) const { return At(pool).queued + At(pool).queued_in_turn; }
  int request_threads() const { return At(Pool::kRequests).thread_count; }
  // Heavy work that runs or is next to run.
  int running_heavy() { return At(Pool::kRequests).limiter.running(); }

  // Returns when all work is done. No work may be posted afterwards.
  void Join();

 private:
  struct Threads {
    // `in_turn`: maximum threads for work of PostFair.
    Threads(int count, int in_turn)
        : thread_count(count), threads(count), limiter(threads, in_turn) {}
    const int thread_count;
    std::atomic<int> queued{0};
    std::atomic<int> queued_in_turn{0};
    ThreadPool threads;
    ConcurrencyLimiter limiter;
  };

  Threads& At(Pool pool) { return pools_[static_cast<std::size_t>(pool)]; }
  const Threads& At(Pool pool) const { return pools_[static_cast<std::size_t>(pool)]; }

  std::array<Threads, 6> pools_;  // by Pool
};

}  // namespace motiondb::server
