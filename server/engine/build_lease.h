// Which server builds the models of a database of a shared store.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/work/executor.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::server {

// Returns a name for this server as a holder: host, process id and a random number.
std::string NewHolderName();

// The right of this server to build the models of a database of a shared store
// (MotionStore::AcquireBuildLease). Renewed every second while it lives; the destructor releases
// it. Thread-safe.
class BuildLease : public std::enable_shared_from_this<BuildLease> {
 public:
  // A server that stops loses its leases after this time.
  static constexpr std::chrono::milliseconds kDuration{5000};
  static constexpr std::chrono::milliseconds kRenewal{1000};

  // ABORTED if another holder has the lease. Store and executor must outlive the lease.
  static absl::StatusOr<std::shared_ptr<BuildLease>> Acquire(storage::MotionStore& store,
                                                             Executor& executor,
                                                             const std::string& database,
                                                             const std::string& holder);
  ~BuildLease();

  std::int64_t fence() const { return fence_; }
  // Returns whether it is known that another server has the lease. While the store cannot be
  // reached, the lease counts as held: the store checks the fence of each model.
  bool is_lost() const { return is_lost_; }
  // Renews it now, and returns whether it is still held.
  bool Renew();

 private:
  BuildLease(storage::MotionStore& store, Executor& executor, std::string database,
             std::int64_t fence);
  // Sets the timer of the next renewal.
  void Arm();

  storage::MotionStore& store_;
  Executor& executor_;
  const std::string database_;
  const std::int64_t fence_;
  std::atomic<bool> is_lost_{false};
  storage::Mutex mutex_;
  const std::unique_ptr<Executor::Timer> timer_ ABSL_PT_GUARDED_BY(mutex_);
};

// When a server requests a build that another one has not: it stored a change, and stopped before
// it stored the operation. Not thread-safe.
class MissedBuild {
 public:
  // `spread`: differs between servers, so that one of them is the first.
  explicit MissedBuild(std::chrono::milliseconds spread) : spread_(spread) {}

  // Called at each look at the store. `is_changed`: the database has changed. `is_busy`: an
  // operation of it has not ended, or this server is updating its model. Returns true, once after
  // changes, if it was not busy for some seconds: the caller then checks the model.
  bool IsDue(Executor::Clock::time_point now, bool is_changed, bool is_busy);
  // Returns whether a build may be requested if the model is out of date. `newest`: the last
  // operation of the database; null: none. If it was cancelled or has failed, the next change
  // requests the build.
  bool MayRequest(const storage::OperationRecord* newest, std::int64_t revision);
  // `requested`: whether a build was requested. After UNAVAILABLE the next look checks again. The
  // delay doubles with each request until the model is up to date.
  void Checked(const absl::StatusOr<bool>& requested);

 private:
  static constexpr std::chrono::milliseconds kDelay{3000};
  static constexpr std::chrono::milliseconds kMaxDelay{600'000};

  const std::chrono::milliseconds spread_;
  std::chrono::milliseconds delay_ = kDelay;
  bool is_unchecked_ = false;
  Executor::Clock::time_point due_;
  std::string stopped_operation_;      // cancelled or failed
  std::int64_t stopped_revision_ = 0;  // of the changes that wait because of it
};

}  // namespace motiondb::server
