// What a server is started with.
#pragma once

#include <string>

#include "server/engine/options.h"
#include "server/rpc/call_limits.h"
#include "server/security/security_options.h"

namespace motiondb::server {

struct ServerOptions {
  std::string listen = "127.0.0.1:50051";  // port 0: a free one
  int max_message_bytes = 16 << 20;        // largest request taken; a query may carry a whole file
  CallLimitOptions calls;
  SecurityOptions security;
  EngineOptions engine;
};

}  // namespace motiondb::server
