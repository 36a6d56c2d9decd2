// The right of this server to build the models of a database of a shared store
// (MotionStore::AcquireBuildLease). Renewed every second while it lives; the destructor releases
// it. Thread-safe.
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

namespace motiondb::server {

// Returns a name for this server as a holder: host, process id and a random number.
std::string NewHolderName();

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

}  // namespace motiondb::server
