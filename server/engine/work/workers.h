// The engine's threads: one pool for requests, one for builds, so that a build never takes the last
// core from queries, two threads for changes, one for each import that may run, and one for each
// other pool (executor.h). All have the same priority: with a lower priority, builds would starve
// on a busy machine.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "server/engine/work/engine_options.h"
#include "server/engine/work/executor.h"

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
  int queued(Pool pool) const;
  int request_threads() const;
  // Heavy work that runs or is next to run.
  int running_heavy();

  // Returns when all work is done. No work may be posted afterwards.
  void Join();

 private:
  struct Threads;  // of one pool; in workers.cc, so that users of this header do not read Asio

  Threads& At(Pool pool) { return *pools_[static_cast<std::size_t>(pool)]; }
  const Threads& At(Pool pool) const { return *pools_[static_cast<std::size_t>(pool)]; }

  std::array<std::unique_ptr<Threads>, 6> pools_;  // by Pool
};

}  // namespace motiondb::server
