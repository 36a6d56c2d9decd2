// `motiondbd migrate FROM TO`: copies a store between a file and PostgreSQL, without a server.
#pragma once

#include <span>

namespace motiondb::server {

// `arguments`: those after the program's name; the first is "migrate". Returns the exit code: 0, 1
// after an error, 2 for a wrong command line.
int RunMigrate(std::span<const char* const> arguments);

}  // namespace motiondb::server
