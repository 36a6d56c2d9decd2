#include "server/engine/thread_pool.h"

#include <spdlog/spdlog.h>

#include <exception>

namespace motiondb::server {

ThreadPool::ThreadPool(int threads) {
  try {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Run(); });
  } catch (...) {
    Stop();
    throw;
  }
}

ThreadPool::~ThreadPool() { Stop(); }

void ThreadPool::Run() {
  while (true) {
    try {
      context_.run();
      return;
    } catch (const std::exception& error) {
      // Work that can fail catches what it throws: this is the last resort, so that one handler
      // does not end the process.
      spdlog::error("work on a server thread ended with an exception: {}", error.what());
    }
  }
}

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
