#include "server/engine/missed_build.h"

#include <algorithm>
#include <utility>

namespace motiondb::server {

bool MissedBuild::IsDue(Executor::Clock::time_point now, bool is_changed, bool is_busy) {
  is_unchecked_ = is_unchecked_ || is_changed;
  if (is_changed || is_busy) due_ = now + delay_ + spread_;
  if (now < due_) return false;
  return std::exchange(is_unchecked_, false);
}

bool MissedBuild::MayRequest(const storage::OperationRecord* newest, std::int64_t revision) {
  if (newest == nullptr || newest->state == storage::OperationState::kSucceeded) return true;
  if (!newest->done()) {  // it has come since the look
    is_unchecked_ = true;
    return false;
  }
  if (std::exchange(stopped_operation_, newest->id) != newest->id) stopped_revision_ = revision;
  return revision > stopped_revision_;
}

void MissedBuild::Checked(const absl::StatusOr<bool>& requested) {
  is_unchecked_ = is_unchecked_ || absl::IsUnavailable(requested.status());
  if (requested.ok()) delay_ = *requested ? std::min(2 * delay_, kMaxDelay) : kDelay;
}

}  // namespace motiondb::server
