// What calls of clients need to reach the gRPC server of this process.
#pragma once

#include <grpcpp/generic/generic_stub.h>

#include <cstdint>
#include <utility>

#include "server/rpc/call_limits.h"
#include "server/rpc/call_memory.h"

namespace motiondb::server {

// Shared by all calls, of HTTP/2 and of the gateway; outlives them. Thread-safe.
struct CallBridge {
  CallBridge(grpc::GenericStub stub, std::int64_t memory_bytes, const CallLimits& call_limits,
             std::uint32_t max_message_size)
      : calls(std::move(stub)),
        memory(memory_bytes),
        limits(call_limits),
        max_message_bytes(max_message_size) {}

  grpc::GenericStub calls;  // to the gRPC server of this process
  CallMemory memory;        // for headers and messages in transit, not for the work on them
  const CallLimits& limits;
  const std::uint32_t max_message_bytes;
};

}  // namespace motiondb::server
