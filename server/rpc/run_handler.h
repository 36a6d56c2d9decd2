// A piece of a call's work, whatever it does, comes to a status.
#pragma once

#include <grpcpp/support/status.h>

#include <functional>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"

namespace motiondb::server {

// The handler's status as gRPC's; exceptions become RESOURCE_EXHAUSTED (memory) or INTERNAL.
// CANCELLED, without running the handler, where nobody waits any more, and where that is so while
// the handler waits for its turn to read the store.
grpc::Status RunHandler(const core::Cancelled& cancelled,
                        const std::function<absl::Status()>& handler);

}  // namespace motiondb::server
