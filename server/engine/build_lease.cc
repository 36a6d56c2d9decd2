#include "server/engine/build_lease.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

std::string NewHolderName() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  std::random_device random;
  return fmt::format("{}/{}/{:08x}", host.data(), getpid(), random());
}

absl::StatusOr<std::shared_ptr<BuildLease>> BuildLease::Acquire(storage::MotionStore& store,
                                                                Executor& executor,
                                                                const std::string& database,
                                                                const std::string& holder) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t fence,
                            store.AcquireBuildLease(database, holder, kDuration));
  std::shared_ptr<BuildLease> lease(new BuildLease(store, executor, database, fence));
  lease->Arm();
  return lease;
}

BuildLease::BuildLease(storage::MotionStore& store, Executor& executor, std::string database,
                       std::int64_t fence)
    : store_(store),
      executor_(executor),
      database_(std::move(database)),
      fence_(fence),
      timer_(executor.MakeTimer(Pool::kChanges)) {}

BuildLease::~BuildLease() {
  // On an error it expires.
  if (!is_lost_) store_.ReleaseBuildLease(database_, fence_).IgnoreError();
}

bool BuildLease::Renew() {
  const absl::Status renewed = store_.RenewBuildLease(database_, fence_, kDuration);
  const bool is_lost = absl::IsAborted(renewed) || absl::IsNotFound(renewed);
  if (is_lost && !is_lost_.exchange(true)) {
    spdlog::warn("database '{}': {}", database_, std::string(renewed.message()));
  }
  return !is_lost_;
}

void BuildLease::Arm() {
  const storage::MutexLock lock(mutex_);
  timer_->Set(executor_.Now() + kRenewal, [weak = weak_from_this()] {
    const auto self = weak.lock();
    if (self != nullptr && self->Renew()) self->Arm();
  });
}

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
