// The engine's threads: one pool for requests, one for building models, so that a build never takes
// the last core from queries, two threads for changes and one each of the others (executor.h).
// All have the same priority: nicer threads would build nothing on a machine that is always asked.
// Thread-safe.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "server/engine/executor.h"
#include "server/engine/lane.h"
#include "server/engine/options.h"
#include "server/engine/thread_pool.h"

namespace motiondb::server {

// Pieces of work that no thread has begun, by the threads that they wait for.
struct QueueLengths {
  int requests = 0;
  int heavy_requests = 0;
  int changes = 0;
  int urgent_changes = 0;
  int upkeep = 0;
};

class Workers : public Executor {
 public:
  // Threads that one made with these options starts.
  static int ThreadCount(const EngineOptions& options);

  explicit Workers(const EngineOptions& options);
  ~Workers() override;

  Clock::time_point Now() const override { return Clock::now(); }
  void Post(Pool pool, Work work) override;
  std::unique_ptr<Timer> MakeTimer(Pool pool) override;
  core::ParallelFor Parallel(Pool pool) override;

  // Runs work that takes long, or waits for others, on a pool's thread: where a pool has several,
  // some stay with what is posted otherwise, and clients take turns.
  void PostInTurn(Pool pool, const std::string& client, Work work);
  QueueLengths queued() const;
  // Work that no thread has begun.
  int queued(Pool pool) const { return At(pool).queued + At(pool).queued_in_turn; }
  int request_threads() const { return At(Pool::kRequests).thread_count; }
  // Heavy work that has a thread or is next for one.
  int running_heavy() { return At(Pool::kRequests).lane.running(); }

  // Returns when all work is done. Nothing may be posted afterwards.
  void Join();

 private:
  struct Threads {
    // `in_turn`: threads that work that takes turns may have.
    Threads(int count, int in_turn) : thread_count(count), threads(count), lane(threads, in_turn) {}
    const int thread_count;
    std::atomic<int> queued{0};
    std::atomic<int> queued_in_turn{0};
    ThreadPool threads;
    Lane lane;
  };

  Threads& At(Pool pool) { return pools_[static_cast<std::size_t>(pool)]; }
  const Threads& At(Pool pool) const { return pools_[static_cast<std::size_t>(pool)]; }

  std::array<Threads, 5> pools_;  // by Pool
};

}  // namespace motiondb::server
