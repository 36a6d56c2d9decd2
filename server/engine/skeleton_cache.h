// Cache of the skeletons that observations reference.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/motion/skeleton.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class SkeletonCache {
 public:
  // The store must outlive the cache.
  explicit SkeletonCache(storage::MotionStore& store) : store_(store) {}

  // NOT_FOUND.
  absl::StatusOr<std::shared_ptr<const core::Skeleton>> Get(const std::string& database,
                                                            const std::string& skeleton);
  // Drops all entries. Called after a deletion, which may have deleted skeletons.
  void Clear();

 private:
  storage::MotionStore& store_;
  storage::Mutex mutex_;
  std::map<std::pair<std::string, std::string>, std::shared_ptr<const core::Skeleton>> skeletons_
      ABSL_GUARDED_BY(mutex_);
  int clear_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace motiondb::server
