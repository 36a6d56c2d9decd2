#include "server/rpc/backup_store.h"

#include <memory>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<NextMessage<v1::BackupStoreResponse>> OpenBackup(const Call& call,
                                                                const v1::BackupStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto made, call.engine.store().upkeep().BeginBackup(call.cancelled));
  std::shared_ptr<storage::StoreBackup> backup = std::move(made);
  return [backup, first = true](v1::BackupStoreResponse& message) mutable -> absl::StatusOr<bool> {
    if (std::exchange(first, false)) message.set_total_bytes(backup->total_bytes());
    return backup->Read(*message.mutable_block());
  };
}

}  // namespace motiondb::server
