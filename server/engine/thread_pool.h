// Threads that run handlers: posted work and timers. Unlike boost::asio::thread_pool it outlives
// what a handler throws, which is logged, and a thread that cannot be started. Thread-safe.
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <thread>
#include <vector>

namespace motiondb::server {

// Runs handlers on the calling thread until the context has no more work or is stopped. What a
// handler throws is logged, and costs what it did alone.
void RunHandlers(boost::asio::io_context& context);

class ThreadPool {
 public:
  using Executor = boost::asio::io_context::executor_type;

  // Throws std::system_error if a thread cannot be started; those started before have ended then.
  explicit ThreadPool(int threads);
  // Ends handlers under way; handlers that have not begun are dropped.
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  Executor executor() { return context_.get_executor(); }
  boost::asio::io_context& context() { return context_; }

  // Returns when all work is done and all timers have ended. Nothing may be posted afterwards.
  void Join();
  // Returns when no handler runs any more, and none begins.
  void Stop();

 private:
  boost::asio::io_context context_;
  boost::asio::executor_work_guard<Executor> has_work_{context_.get_executor()};
  std::vector<std::thread> threads_;
};

}  // namespace motiondb::server
