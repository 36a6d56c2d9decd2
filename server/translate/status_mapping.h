// The one place where an absl::Status becomes a grpc::Status. Safe to call from any thread.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace motiondb::server {

// The same canonical code; the message as one line of valid UTF-8 of at most 1 KiB, without display
// controls and without the secrets of tokens, since gRPC's trailers hold
// 8; payloads as the details of a motiondb.v1.Status, which travels in `grpc-status-details-bin`.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace motiondb::server
