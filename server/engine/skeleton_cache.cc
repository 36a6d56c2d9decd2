#include "server/engine/skeleton_cache.h"

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxSkeletons = 256;

}  // namespace

absl::StatusOr<std::shared_ptr<const core::Skeleton>> SkeletonCache::Get(
    const std::string& database, const std::string& skeleton) {
  const std::pair key(database, skeleton);
  int clear_count = 0;
  {
    const storage::MutexLock lock(mutex_);
    if (const auto kept = skeletons_.find(key); kept != skeletons_.end()) return kept->second;
    clear_count = clear_count_;
  }
  MOTIONDB_ASSIGN_OR_RETURN(core::Skeleton read, store_.GetSkeleton(database, skeleton));
  auto shared = std::make_shared<const core::Skeleton>(std::move(read));
  const storage::MutexLock lock(mutex_);
  // A skeleton that was read before a deletion must not be cached after it.
  if (clear_count != clear_count_) return shared;
  if (skeletons_.size() >= kMaxSkeletons) skeletons_.clear();
  skeletons_[key] = shared;
  return shared;
}

void SkeletonCache::Clear() {
  const storage::MutexLock lock(mutex_);
  skeletons_.clear();
  ++clear_count_;
}

}  // namespace motiondb::server
