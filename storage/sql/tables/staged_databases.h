// The databases that are being imported. They are hidden like deleted ones; a purge must leave
// them. Thread-safe.
#pragma once

#include <cstdint>
#include <set>

#include "storage/mutex.h"

namespace motiondb::storage {

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

}  // namespace motiondb::storage
