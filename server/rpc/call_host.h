// Shared state of all services.
#pragma once

#include "server/engine/engine.h"
#include "server/observability/monitor.h"
#include "server/rpc/call_gate.h"
#include "server/rpc/call_limits.h"
#include "server/rpc/call_memory.h"
#include "server/security/access_control.h"

namespace motiondb::server {

struct CallHost {
  Engine& engine;
  AccessControl access;
  CallLimits limits;
  CallMemory memory;
  CallGate gate;
  Monitor& monitor;
};

}  // namespace motiondb::server
