// Whether writing to the store works: counts the writes that failed, and decides when a trial write
// is due. Thread-safe.
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
  // To be called with the result of each write. Counts failures of the store itself, not those of
  // the request, such as NOT_FOUND.
  void Note(const absl::Status& written);
  WriteFailures failures() const;
  // The last write failed.
  bool is_suspect() const { return suspect_; }
  // The result of `write`, which is called once a second at most; between calls, and while another
  // thread waits for it, the last result. CANCELLED from `write` means: not known, as before.
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
