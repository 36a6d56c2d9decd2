// Shared state of all services.
#pragma once

#include "server/engine/engine.h"
#include "server/observability/monitor.h"
#include "server/rpc/call_limits.h"
#include "server/rpc/call_memory.h"
#include "server/rpc/call_registry.h"
#include "server/rpc/running_streams.h"
#include "server/security/access_control.h"

namespace motiondb::server {

struct ServiceContext {
  Engine& engine;
  AccessControl access;
  CallLimits limits;
  CallMemory memory;
  CallRegistry registry;
  Monitor& monitor;
  RunningStreams streams = {};
};

}  // namespace motiondb::server
