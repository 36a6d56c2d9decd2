// What an operator can set about motiondbd: the values, wherever they came from.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/engine/options.h"
#include "server/observability/log.h"
#include "server/rpc/call_limits.h"
#include "server/security/security_options.h"

namespace motiondb::server {

// What a server is started with.
struct ServerOptions {
  std::string listen = "127.0.0.1:50051";  // port 0: a free one
  int max_message_bytes = 16 << 20;        // largest request taken; a query may carry a whole file
  CallLimitOptions calls;
  SecurityOptions security;
  EngineOptions engine;
};

struct LogSettings {
  std::string level = "info";
  LogFormat format = LogFormat::kText;
  std::chrono::milliseconds slow_call{2000};  // from which on a call is logged as slow
};

struct Settings {
  std::string store_path;  // required
  bool read_only = false;  // as SqliteOptions::read_only
  // As SqliteOptions::reserve_bytes.
  std::int64_t disk_reserve_bytes = std::int64_t{64} << 20;
  LogSettings log;
  std::chrono::milliseconds grace{10'000};  // that running calls may take after SIGTERM
  std::string http_listen;                  // as StartHealthServer takes it
  ServerOptions server;
};

}  // namespace motiondb::server
