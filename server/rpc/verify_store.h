// StoreService.VerifyStore.
#pragma once

#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/stream_reactor.h"

namespace motiondb::server {

absl::StatusOr<NextMessage<v1::VerifyStoreResponse>> OpenVerify(
    const Call& call, const v1::VerifyStoreRequest& request);

}  // namespace motiondb::server
