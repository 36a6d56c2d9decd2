#include "storage/motion_store.h"

#include "core/motion/error.h"

namespace motiondb::storage {

absl::Status SameClipError(const ClipRecord& same, const NewClip& clip) {
  const std::string& database = clip.record.database;
  const bool has_same_motion = same.content_hash == clip.record.content_hash;
  const std::string message =
      has_same_motion
          ? fmt::format("database '{}' already has the same motion as clip '{}'", database, same.id)
          : fmt::format("database '{}' already has another clip '{}'", database, same.id);
  return core::WithResource("clip", fmt::format("databases/{}/clips/{}", database, same.id),
                            core::WithReason(has_same_motion ? "MOTION_EXISTS" : "CLIP_EXISTS",
                                             absl::AlreadyExistsError(message)));
}

absl::Status MotionStore::AnnounceServer(const ServerAddress&, std::chrono::milliseconds) {
  return absl::OkStatus();
}

absl::StatusOr<std::vector<ServerAddress>> MotionStore::ListServers() {
  return std::vector<ServerAddress>();
}

}  // namespace motiondb::storage
