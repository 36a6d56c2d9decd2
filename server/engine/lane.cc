#include "server/engine/lane.h"

#include <boost/asio/post.hpp>
#include <utility>

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

void Lane::Start(std::function<void()> work) {
  boost::asio::post(pool_, [this, work = std::move(work)] {
    work();
    Next();
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
