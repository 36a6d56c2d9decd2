// StoreService.BackupStore.
#pragma once

#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/stream_reactor.h"

namespace motiondb::server {

absl::StatusOr<NextMessage<v1::BackupStoreResponse>> OpenBackup(
    const Call& call, const v1::BackupStoreRequest& request);

}  // namespace motiondb::server
