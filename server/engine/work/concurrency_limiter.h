// Concurrency limiter for a thread pool: runs at most `width` posted pieces of work at a time and
// queues the rest. Keeps threads free for light work while heavy work, which takes seconds, runs.
// Clients take turns: a piece waits for at most one piece of each other client. Must outlive its
// work.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>

#include "server/engine/work/thread_pool.h"
#include "storage/mutex.h"

namespace motiondb::server {

class ConcurrencyLimiter {
 public:
  // `width`: at least 1.
  ConcurrencyLimiter(ThreadPool& pool, int width) : pool_(pool), width_(width), free_(width) {}

  // Runs `work`, which must not throw, on a thread of the pool. Work of one client starts in order.
  void Post(const std::string& client, std::function<void()> work);
  // Pieces of work that were passed to the pool and have not ended.
  int running();

 private:
  using Queue = std::deque<std::function<void()>>;

  void Start(std::function<void()> work);
  void Next();

  ThreadPool& pool_;
  const int width_;
  storage::Mutex mutex_;
  int free_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Queue> waiting_ ABSL_GUARDED_BY(mutex_);  // by client; no queue is empty
  std::deque<std::string> turns_ ABSL_GUARDED_BY(mutex_);         // clients in waiting_, next first
};

}  // namespace motiondb::server
