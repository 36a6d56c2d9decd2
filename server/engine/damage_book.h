// Corruption found since the start, for the health report.
#pragma once

#include <cstddef>
#include <vector>

#include "storage/mutex.h"
#include "storage/store_upkeep.h"

namespace motiondb::server {

class DamageBook {
 public:
  static constexpr std::size_t kLimit = 100;

  // Logs and records `damage`, unless it is already recorded or the list has kLimit entries.
  void Note(const storage::Damage& damage);
  // In the order of discovery.
  std::vector<storage::Damage> List() const;

 private:
  mutable storage::Mutex mutex_;
  std::vector<storage::Damage> damages_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
