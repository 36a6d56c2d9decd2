// A narrow way to a pool of threads: at most so many pieces of the work that goes through it run at
// a time, and the others wait in order. Heavy work, which would else take every thread for seconds,
// leaves the rest to light work. Thread-safe; outlives its work.
#pragma once

#include <deque>
#include <functional>
#include <mutex>

#include "server/engine/thread_pool.h"

namespace motiondb::server {

class Lane {
 public:
  // `width`: at least 1.
  Lane(ThreadPool& pool, int width) : pool_(pool), width_(width), free_(width) {}

  // Runs a piece of work, which must not throw, on a thread of the pool.
  void Post(std::function<void()> work);
  // Pieces of work that were given to the pool and have not ended.
  int running();

 private:
  void Start(std::function<void()> work);
  void Next();

  ThreadPool& pool_;
  const int width_;
  std::mutex mutex_;
  int free_;
  std::deque<std::function<void()>> waiting_;
};

}  // namespace motiondb::server
