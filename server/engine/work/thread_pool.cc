#include "server/engine/work/thread_pool.h"

#include <spdlog/spdlog.h>

#include <exception>

namespace motiondb::server {

void RunHandlers(boost::asio::io_context& context) {
  while (true) {
    try {
      context.run();
      return;
    } catch (const std::exception& error) {
      // Last resort, so that one handler does not end the process: work that may fail catches its
      // own exceptions.
      spdlog::error("unhandled exception on a server thread: {}", error.what());
    }
  }
}

ThreadPool::ThreadPool(int threads) {
  try {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { RunHandlers(context_); });
  } catch (...) {
    Stop();
    throw;
  }
}

ThreadPool::~ThreadPool() { Stop(); }

void ThreadPool::Join() {
  has_work_.reset();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void ThreadPool::Stop() {
  context_.stop();
  Join();
}

}  // namespace motiondb::server
