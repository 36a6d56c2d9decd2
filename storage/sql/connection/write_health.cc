#include "storage/sql/connection/write_health.h"

namespace motiondb::storage {
namespace {

constexpr std::chrono::seconds kBetweenTrials{1};

}  // namespace

void WriteHealth::Note(const absl::Status& written) {
  switch (written.code()) {
    case absl::StatusCode::kOk:
      suspect_ = false;
      return;
    case absl::StatusCode::kResourceExhausted:
      ++no_space_;
      break;
    case absl::StatusCode::kUnavailable:
      ++io_error_;
      break;
    case absl::StatusCode::kDataLoss:
      ++corruption_;
      break;
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
      ++other_;
      break;
    default:
      return;
  }
  suspect_ = true;
}

WriteFailures WriteHealth::failures() const {
  return {.no_space = no_space_, .io_error = io_error_, .corruption = corruption_, .other = other_};
}

absl::Status WriteHealth::Try(const std::function<absl::Status()>& write) {
  {
    const MutexLock lock(mutex_);
    const bool is_due = tried_ == Clock::time_point() || Clock::now() - tried_ >= kBetweenTrials;
    if (trying_ || !is_due) return result_;
    trying_ = true;
  }
  absl::Status result = write();
  const MutexLock lock(mutex_);
  trying_ = false;
  tried_ = Clock::now();
  if (!absl::IsCancelled(result)) result_ = std::move(result);
  if (result_.ok()) suspect_ = false;
  return result_;
}

}  // namespace motiondb::storage
