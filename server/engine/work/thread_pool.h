// Threads that run posted work and timers, and a limit of the heavy work among it.
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "storage/mutex.h"

namespace motiondb::server {

// Runs handlers on the calling thread until the context has no more work or is stopped. Logs the
// exception of a handler and continues with the next.
void RunHandlers(boost::asio::io_context& context);

// Threads that run handlers: posted work and timers. Unlike boost::asio::thread_pool it survives
// exceptions of handlers, which it logs, and a thread that cannot be started.
class ThreadPool {
 public:
  using Executor = boost::asio::io_context::executor_type;

  // Throws std::system_error if a thread cannot be started, after the other threads have ended.
  explicit ThreadPool(int threads);
  // Waits for running handlers; drops handlers that have not begun.
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  Executor executor() { return context_.get_executor(); }
  boost::asio::io_context& context() { return context_; }

  // Returns when all work is done and all timers have ended. No work may be posted afterwards.
  void Join();
  // Returns when no handler runs; none begins afterwards.
  void Stop();

 private:
  boost::asio::io_context context_;
  boost::asio::executor_work_guard<Executor> has_work_{context_.get_executor()};
  std::vector<std::thread> threads_;
};

// Concurrency limiter for a thread pool: runs at most `width` posted pieces of work at a time and
// queues the rest. Keeps threads free for light work while heavy work, which takes seconds, runs.
// Clients take turns: a piece waits for at most one piece of each other client. Must outlive its
// work.
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
