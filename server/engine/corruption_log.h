// Corruption found since the start, for the health report.
#pragma once

#include <cstddef>
#include <vector>

#include "storage/mutex.h"
#include "storage/store_maintenance.h"

namespace motiondb::server {

class CorruptionLog {
 public:
  static constexpr std::size_t kLimit = 100;

  // Logs and records `corruption`, unless it is already recorded or the list has kLimit entries.
  void Note(const storage::Corruption& corruption);
  // In the order of discovery.
  std::vector<storage::Corruption> List() const;

 private:
  mutable storage::Mutex mutex_;
  std::vector<storage::Corruption> corruptions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
