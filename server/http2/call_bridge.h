// What calls of clients need to reach the gRPC server of this process.
#pragma once

#include <grpcpp/generic/generic_stub.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "server/observability/monitor.h"
#include "server/rpc/call_limits.h"

namespace motiondb::server {

// Shared by all calls, of HTTP/2 and of the gateway; outlives them. Thread-safe.
struct CallBridge {
  CallBridge(grpc::GenericStub stub, std::int64_t memory_bytes, const CallLimits& call_limits,
             std::uint32_t max_message_size, Monitor& call_monitor)
      : calls(std::move(stub)),
        memory(memory_bytes),
        limits(call_limits),
        max_message_bytes(max_message_size),
        monitor(call_monitor) {}

  // Counts and logs a call that ends with `error` before it reaches the gRPC server, which does so
  // for all others. Returns the error with the request id. `path`: "/motiondb.v1.SERVICE/METHOD".
  // `request_id`: of the client; can be empty.
  grpc::Status Refuse(std::string_view path, const grpc::Status& error,
                      const std::string& request_id, const std::string& peer) const;

  grpc::GenericStub calls;  // to the gRPC server of this process
  CallMemory memory;        // for headers and messages in transit, not for the work on them
  const CallLimits& limits;
  const std::uint32_t max_message_bytes;
  Monitor& monitor;
};

}  // namespace motiondb::server
