#include "server/engine/work/thread_pool.h"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

#include "absl/cleanup/cleanup.h"

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

void ConcurrencyLimiter::Post(const std::string& client, std::function<void()> work) {
  {
    const storage::MutexLock lock(mutex_);
    if (free_ == 0) {
      Queue& queue = waiting_[client];
      if (queue.empty()) turns_.push_back(client);
      queue.push_back(std::move(work));
      return;
    }
    --free_;
  }
  Start(std::move(work));
}

int ConcurrencyLimiter::running() {
  const storage::MutexLock lock(mutex_);
  return width_ - free_;
}

void ConcurrencyLimiter::Start(std::function<void()> work) {
  boost::asio::post(pool_.executor(), [this, work = std::move(work)] {
    // Also if the work throws: its place must not be lost.
    const absl::Cleanup next = [this] { Next(); };
    work();
  });
}

void ConcurrencyLimiter::Next() {
  std::function<void()> work;
  {
    const storage::MutexLock lock(mutex_);
    if (turns_.empty()) {
      ++free_;
      return;
    }
    std::string client = std::move(turns_.front());
    turns_.pop_front();
    const auto queue = waiting_.find(client);
    work = std::move(queue->second.front());
    queue->second.pop_front();
    if (queue->second.empty()) {
      waiting_.erase(queue);
    } else {
      turns_.push_back(std::move(client));
    }
  }
  Start(std::move(work));
}

}  // namespace motiondb::server
