// Health of writes: counts failed writes and decides when a test write is due. Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>

#include "absl/status/status.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::storage {

class WriteHealth {
 public:
  // Records the result of a write. Counts failures of the store, not of the request (NOT_FOUND).
  void Note(const absl::Status& written);
  WriteFailures failures() const;
  // Returns whether the last write failed.
  bool is_suspect() const { return suspect_; }
  // Calls `write` at most once a second and returns its result. Between calls, and while another
  // thread is calling `write`, returns the last result. CANCELLED from `write` keeps the last
  // result.
  absl::Status Try(const std::function<absl::Status()>& write);

 private:
  using Clock = std::chrono::steady_clock;

  std::atomic<std::int64_t> no_space_ = 0;
  std::atomic<std::int64_t> io_error_ = 0;
  std::atomic<std::int64_t> corruption_ = 0;
  std::atomic<std::int64_t> other_ = 0;
  std::atomic<bool> suspect_ = false;
  Mutex mutex_;
  bool trying_ ABSL_GUARDED_BY(mutex_) = false;
  Clock::time_point tried_ ABSL_GUARDED_BY(mutex_);  // epoch: never
  absl::Status result_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::storage
