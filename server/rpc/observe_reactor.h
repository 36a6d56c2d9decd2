// Answers Observe: one message of frames after the other, each on a request thread, and none is
// read before the answer to the one before it was written, so a client costs one message of memory
// however fast it sends or slowly it reads.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/rpc/call.h"

namespace motiondb::v1 {
class ObserveRequest;
class ObserveResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Owned by gRPC: deletes itself when the call is over.
grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    CallHost& host, grpc::CallbackServerContext& context);

}  // namespace motiondb::server
