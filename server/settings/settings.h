// What an operator can set about motiondbd: the values, wherever they came from.
#pragma once

#include <chrono>
#include <string>

#include "server/server.h"

namespace motiondb::server {

struct LogSettings {
  std::string level = "info";
};

struct Settings {
  std::string store_path;  // required
  LogSettings log;
  std::chrono::milliseconds grace{10'000};  // that running calls may take after SIGTERM
  ServerOptions server;
};

}  // namespace motiondb::server
