// Threads that run handlers: posted work and timers. Unlike boost::asio::thread_pool it survives
// exceptions of handlers, which it logs, and a thread that cannot be started.
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <thread>
#include <vector>

namespace motiondb::server {

// Runs handlers on the calling thread until the context has no more work or is stopped. Logs the
// exception of a handler and continues with the next.
void RunHandlers(boost::asio::io_context& context);

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

}  // namespace motiondb::server
