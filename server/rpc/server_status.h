// StoreService.GetServerStatus.
#pragma once

#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"

namespace motiondb::server {

absl::Status GetServerStatus(const Call& call, const v1::GetServerStatusRequest& request,
                             v1::GetServerStatusResponse& response);

}  // namespace motiondb::server
