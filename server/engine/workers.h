// The threads that do the work: one pool for requests, one for building models, so that a build
// never takes the last core from queries, a thread that extends models while others are built, two
// that change what the store lists, and one that copies and checks it.
// All have the same priority: nicer threads would build nothing on a machine that is always asked.
// Thread-safe.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "core/tree/parallel.h"
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

class Workers {
 public:
  using Executor = ThreadPool::Executor;

  // Threads that one made with these options starts.
  static int ThreadCount(const EngineOptions& options);

  explicit Workers(const EngineOptions& options);
  ~Workers();

  // Runs a piece of work, which must not throw, on a request thread.
  void Post(std::function<void()> work);
  // The same of work that takes long: some request threads always stay with the rest, and clients
  // take turns.
  void PostHeavy(const std::string& client, std::function<void()> work);
  // The same of changes of the store, which takes one at a time: on a thread of their own, for
  // while a large model is written they wait, and queries must not.
  void PostChange(std::function<void()> work);
  // The same of those that other changes must not keep waiting, as where a token is revoked.
  void PostUrgentChange(std::function<void()> work);
  // The same of work on the store as a whole, on a thread that nothing else waits for.
  void PostUpkeep(std::function<void()> work);
  // Whether such work waits for that thread.
  bool upkeep_waits() const { return queued_upkeep_.load(std::memory_order_relaxed) > 0; }
  QueueLengths queued() const;
  int request_threads() const { return request_threads_; }
  // Heavy work that has a thread or is next for one.
  int running_heavy() { return heavy_requests_.running(); }

  Executor request_executor() { return requests_.executor(); }
  Executor build_executor() { return builds_.executor(); }
  Executor extension_executor() { return extensions_.executor(); }

  // Lends the build pool's threads. The calling thread works too, so a loop ends even where every
  // other thread is taken, and loops may be nested.
  core::ParallelFor build_parallel();
  // The same of the request pool.
  core::ParallelFor request_parallel();

  // Returns when all work is done. Nothing may be posted afterwards.
  void Join();

 private:
  // The work, counted in its queue until it begins.
  static std::function<void()> Counted(std::atomic<int>& queued, std::function<void()> work);

  const int request_threads_;
  const int build_threads_;
  std::atomic<int> queued_requests_{0};
  std::atomic<int> queued_heavy_{0};
  std::atomic<int> queued_changes_{0};
  std::atomic<int> queued_urgent_{0};
  std::atomic<int> queued_upkeep_{0};
  ThreadPool requests_;
  ThreadPool builds_;
  ThreadPool extensions_;
  ThreadPool changes_;
  ThreadPool urgent_changes_;
  ThreadPool upkeep_;
  Lane heavy_requests_;
};

}  // namespace motiondb::server
