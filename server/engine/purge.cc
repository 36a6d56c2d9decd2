#include "server/engine/purge.h"

#include <spdlog/spdlog.h>

namespace motiondb::server {

void PurgeDeletedClips(storage::MotionStore& store, const std::string& database,
                       const core::Cancelled& cancelled) {
  const absl::Status purged = store.PurgeDeletedClips(database, cancelled);
  if (purged.ok() || absl::IsCancelled(purged)) return;
  spdlog::warn("database '{}': what is left of deleted clips could not be removed: {}", database,
               purged.ToString());
}

}  // namespace motiondb::server
