#include "server/engine/live_database.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> LiveDatabase::scheme() const {
  const std::lock_guard lock(mutex_);
  return scheme_;
}

void LiveDatabase::set_scheme(absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme) {
  const std::lock_guard lock(mutex_);
  scheme_ = std::move(scheme);
}

std::shared_ptr<const Snapshot> LiveDatabase::snapshot() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

void LiveDatabase::set_snapshot(std::shared_ptr<const Snapshot> snapshot) {
  {
    const std::lock_guard lock(mutex_);
    snapshot_.swap(snapshot);
  }
  // The old model, if no query holds it, is freed here: outside the lock.
}

StoredAmount LiveDatabase::stored() const {
  const std::lock_guard lock(mutex_);
  return stored_;
}

void LiveDatabase::AddStored(std::int32_t clips, std::int32_t frames) {
  const std::lock_guard lock(mutex_);
  stored_.clip_count += clips;
  stored_.frame_count += frames;
}

absl::Status LiveDatabase::WhileAlive(const std::function<absl::Status()>& change) {
  const std::shared_lock lock(life_mutex_);
  if (deleted_) return core::NotFound("database '{}' was deleted", name_);
  return change();
}

absl::Status LiveDatabase::Retire(const std::function<absl::Status()>& deletion) {
  const std::unique_lock lock(life_mutex_);
  if (deleted_) return core::NotFound("database '{}' was deleted", name_);
  MOTIONDB_RETURN_IF_ERROR(deletion());
  deleted_ = true;
  return absl::OkStatus();
}

}  // namespace motiondb::server
