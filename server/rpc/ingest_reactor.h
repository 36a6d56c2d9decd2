// Answers IngestClip: gathers the stream on gRPC's threads, reads and stores the file on one of
// ours.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/rpc/call.h"

namespace motiondb::v1 {
class IngestClipRequest;
class IngestClipResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Owned by gRPC: deletes itself when the call is over.
grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response);

}  // namespace motiondb::server
