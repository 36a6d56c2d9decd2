// The values of all settings of motiondbd.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "server/engine/work/engine_options.h"
#include "server/observability/log.h"
#include "server/rpc/call_limits.h"
#include "server/security/security_options.h"

namespace motiondb::server {

// Options of a Server.
struct ServerOptions {
  std::string listen = "127.0.0.1:50051";  // port 0: any free port
  std::string advertise;                   // for other servers of the store; empty: `listen`
  std::string web_listen;                  // of the HTTP API; empty: none
  std::string web_root;                    // folder of the web page; empty: the installed one
  int max_message_bytes = 16 << 20;        // of a request; a query may contain a whole file
  CallLimitOptions calls;
  SecurityOptions security;
  EngineOptions engine;
};

struct LogSettings {
  std::string level = "info";
  LogFormat format = LogFormat::kText;
  std::chrono::milliseconds slow_call{2000};  // minimum duration of a call logged as slow
};

struct Settings {
  std::string store_path;  // required; or a URL (storage/store_url.h)
  bool read_only = false;  // SqliteOptions::read_only
  // SqliteOptions::reserve_bytes.
  std::int64_t disk_reserve_bytes = std::int64_t{64} << 20;
  LogSettings log;
  std::chrono::milliseconds grace{10'000};  // time for running calls after SIGTERM
  std::string http_listen;                  // argument of StartHealthServer
  ServerOptions server;
};

}  // namespace motiondb::server
