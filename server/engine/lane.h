// A concurrency limiter before a pool of threads: at most `width` pieces of the work that goes
// through it run at a time, and the others wait. Heavy work, which would else take every thread for
// seconds, leaves the rest to light work. Clients take turns: a piece waits for at most one piece
// of each other client, however many these have. Thread-safe; outlives its work.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>

#include "server/engine/thread_pool.h"
#include "storage/mutex.h"

namespace motiondb::server {

class Lane {
 public:
  // `width`: at least 1.
  Lane(ThreadPool& pool, int width) : pool_(pool), width_(width), free_(width) {}

  // Runs a piece of work, which must not throw, on a thread of the pool. The pieces of one client
  // start in order.
  void Post(const std::string& client, std::function<void()> work);
  // Pieces of work that were given to the pool and have not ended.
  int running();

 private:
  using Queue = std::deque<std::function<void()>>;

  void Start(std::function<void()> work);
  void Next();

  ThreadPool& pool_;
  const int width_;
  storage::Mutex mutex_;
  int free_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Queue> waiting_ ABSL_GUARDED_BY(mutex_);  // by client; none is empty
  std::deque<std::string> turns_
      ABSL_GUARDED_BY(mutex_);  // the clients in waiting_, the next first
};

}  // namespace motiondb::server
