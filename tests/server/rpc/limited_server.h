// Options of a server with given call limits.
#pragma once

#include <chrono>

#include "server/server.h"

namespace motiondb::tests {

inline server::ServerOptions With(const server::CallLimitOptions& calls) {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.engine.rebuild_delay = std::chrono::milliseconds(50);
  options.calls = calls;
  return options;
}

}  // namespace motiondb::tests
