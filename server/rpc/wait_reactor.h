// Answers WaitOperation without holding a thread while it waits.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/rpc/call.h"

namespace motiondb::v1 {
class WaitOperationRequest;
class WaitOperationResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Owned by gRPC: deletes itself when the call is over.
grpc::ServerUnaryReactor* NewWaitReactor(CallHost& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response);

}  // namespace motiondb::server
