// Shared state of all services.
#pragma once

#include <memory>

#include "server/engine/engine.h"
#include "server/observability/monitor.h"
#include "server/rpc/call_limits.h"
#include "server/rpc/call_memory.h"
#include "server/rpc/call_registry.h"
#include "server/rpc/running_streams.h"
#include "server/security/access_control.h"

namespace motiondb::server {

class OtherServers;

struct ServiceContext {
  Engine& engine;
  AccessControl access;
  CallLimits limits;
  CallMemory memory;
  CallRegistry registry;
  Monitor& monitor;
  RunningStreams streams = RunningStreams();
  std::shared_ptr<OtherServers> others = nullptr;  // null: the store is not shared
};

}  // namespace motiondb::server
