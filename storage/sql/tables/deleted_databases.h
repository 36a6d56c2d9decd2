// Frees the disk space of deleted databases, a few megabytes per transaction; and the list of
// databases that are being imported, which a purge must leave.
#pragma once

#include <cstdint>
#include <functional>
#include <set>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// The databases that are being imported. They are hidden like deleted ones; a purge must leave
// them. Thread-safe.
class StagedDatabases {
 public:
  void Add(std::int64_t database_key) {
    const MutexLock lock(mutex_);
    keys_.insert(database_key);
  }
  void Remove(std::int64_t database_key) {
    const MutexLock lock(mutex_);
    keys_.erase(database_key);
  }
  bool Contains(std::int64_t database_key) {
    const MutexLock lock(mutex_);
    return keys_.contains(database_key);
  }
  bool IsEmpty() {
    const MutexLock lock(mutex_);
    return keys_.empty();
  }

 private:
  Mutex mutex_;
  std::set<std::int64_t> keys_ ABSL_GUARDED_BY(mutex_);
};

// Runs `piece` in its own write transaction, which is rolled back on an error.
using TransactionRunner =
    std::function<absl::Status(const std::function<absl::Status(Connection&)>& piece)>;

// See MotionStore::PurgeDeletedDatabases. Leaves the staged ones. Polls `cancelled` between the
// transactions.
absl::Status FreeDeletedDatabases(const TransactionRunner& write, StagedDatabases& staged,
                                  const core::Cancelled& cancelled);

}  // namespace motiondb::storage
