// What was found damaged since the start, for the health report. Thread-safe.
#pragma once

#include <cstddef>
#include <vector>

#include "storage/mutex.h"
#include "storage/store_upkeep.h"

namespace motiondb::server {

class DamageBook {
 public:
  static constexpr std::size_t kLimit = 100;

  // Logs it and keeps it, unless it is known or there are kLimit already.
  void Note(const storage::Damage& damage);
  // In the order in which it was found.
  std::vector<storage::Damage> List() const;

 private:
  mutable storage::Mutex mutex_;
  std::vector<storage::Damage> damages_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
