// Answers RestoreStore: each block goes to the disk before the next is asked for, so a backup of
// any size takes the memory of one.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/rpc/call_host.h"

namespace motiondb::v1 {
class RestoreStoreRequest;
class RestoreStoreResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Owned by gRPC: deletes itself when the call is over.
grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response);

}  // namespace motiondb::server
