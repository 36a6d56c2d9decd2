// The command line of motiondbd.
#pragma once

#include <chrono>
#include <string>

#include "server/server.h"

namespace motiondb::server {

struct CommandLine {
  std::string store_path;
  std::string log_level = "info";
  std::chrono::milliseconds grace{10'000};
  ServerOptions server;
};

// Fills in what was given. If the program is to end now, for --help, --version or a mistake, prints
// what is due and sets `exit_code`, else leaves it as it is. Returns whether to go on.
bool ParseCommandLine(int argc, const char* const* argv, CommandLine& line, int& exit_code);

}  // namespace motiondb::server
