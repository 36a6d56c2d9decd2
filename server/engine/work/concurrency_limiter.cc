#include "server/engine/work/concurrency_limiter.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "absl/cleanup/cleanup.h"

namespace motiondb::server {

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
