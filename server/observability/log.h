// The server's log, on standard error.
#pragma once

#include <string>

#include "server/observability/log_formatter.h"

namespace motiondb::server {

// Once, before anything is logged. `level`: debug, info, warning, error or off.
void StartLog(LogFormat format, const std::string& level);

// Says on standard error what is to be seen whatever the level of the log: why the program ends, or
// that it is open to all. A line of text that begins with the program's name, or a line of JSON of
// the level critical.
void Tell(LogFormat format, const std::string& message);

}  // namespace motiondb::server
