#include "storage/sql/connection/reader_pool.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"

namespace motiondb::storage {

ReaderPool::ReaderPool(Open open, Check check, int limit)
    : open_(std::move(open)),
      check_(std::move(check)),
      limit_(std::max(limit, 1)),
      left_to_open_(limit_) {}

absl::StatusOr<ReaderPool::Lease> ReaderPool::Acquire(const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(auto idle, TakeIdle(cancelled));
  if (idle != nullptr) return Lease(*this, std::move(idle));
  return OpenPromised();
}

std::vector<ReaderPool::Lease> ReaderPool::AcquireIdle() {
  std::vector<Lease> leases;
  int to_open = 0;
  {
    const MutexLock lock(mutex_);
    to_open = left_to_open_;
    if (to_open > 0) --to_open;
    const std::size_t min_idle = left_to_open_ > 0 ? 0 : 1;
    for (; idle_.size() > min_idle; idle_.pop_back()) {
      leases.emplace_back(*this, std::move(idle_.back()));
    }
    left_to_open_ -= to_open;
  }
  for (; to_open > 0; --to_open) {
    auto opened = OpenPromised();
    if (opened.ok()) leases.push_back(*std::move(opened));
  }
  return leases;
}

absl::StatusOr<ReaderPool::Lease> ReaderPool::OpenPromised() {
  auto opened = open_();
  if (opened.ok() && check_) {
    if (absl::Status checked = check_(); !checked.ok()) opened = std::move(checked);
  }
  if (!opened.ok()) {
    const MutexLock lock(mutex_);
    ++left_to_open_;
    given_back_.NotifyOne();
    return opened.status();
  }
  return Lease(*this, *std::move(opened));
}

absl::StatusOr<std::unique_ptr<Connection>> ReaderPool::TakeIdle(const core::Cancelled& cancelled) {
  const MutexLock lock(mutex_);
  const auto is_available = [this] {
    mutex_.AssertHeld();
    return !idle_.empty() || left_to_open_ > 0;
  };
  if (!is_available()) {
    const auto began = std::chrono::steady_clock::now();
    ++waiting_;
    const bool available = given_back_.WaitOrCancel(mutex_, cancelled, is_available);
    --waiting_;
    ++waited_;
    wait_time_ += std::chrono::steady_clock::now() - began;
    if (!available) return CancelledInQueue();  // no connection is idle: no notification is lost
  }
  if (idle_.empty()) {
    --left_to_open_;
    return nullptr;
  }
  auto connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

ConnectionStatistics ReaderPool::statistics() const {
  const MutexLock lock(mutex_);
  const int open = limit_ - left_to_open_;
  return {.max_readers = limit_,
          .open_readers = open,
          .leased_readers = open - static_cast<int>(idle_.size()),
          .waiting_reads = waiting_,
          .waited_reads = waited_,
          .wait_seconds = wait_time_.count()};
}

void ReaderPool::GiveBack(std::unique_ptr<Connection> connection) {
  const bool is_usable = connection->is_usable();
  const MutexLock lock(mutex_);
  if (is_usable) {
    idle_.push_back(std::move(connection));
  } else {
    ++left_to_open_;  // its server is gone
  }
  given_back_.NotifyOne();
}

}  // namespace motiondb::storage
