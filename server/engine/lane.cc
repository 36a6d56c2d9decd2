#include "server/engine/lane.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "absl/cleanup/cleanup.h"

namespace motiondb::server {

void Lane::Post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (free_ == 0) {
      waiting_.push_back(std::move(work));
      return;
    }
    --free_;
  }
  Start(std::move(work));
}

int Lane::running() {
  const std::lock_guard lock(mutex_);
  return width_ - free_;
}

void Lane::Start(std::function<void()> work) {
  boost::asio::post(pool_.executor(), [this, work = std::move(work)] {
    // Also where the work throws: its place must not be lost.
    const absl::Cleanup next = [this] { Next(); };
    work();
  });
}

void Lane::Next() {
  std::function<void()> work;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) {
      ++free_;
      return;
    }
    work = std::move(waiting_.front());
    waiting_.pop_front();
  }
  Start(std::move(work));
}

}  // namespace motiondb::server
