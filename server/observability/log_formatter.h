// How a log line looks: as text for a person, or as one JSON object for a machine. Either way it is
// one line of valid UTF-8, whatever the message: nobody forges a line by a name with a line end.
// Display controls (core/format/text_encoding.h) are escaped, and the secrets of tokens left out.
#pragma once

#include <spdlog/formatter.h>

#include <memory>

namespace motiondb::server {

enum class LogFormat { kText, kJson };

// For spdlog::set_formatter. What it makes carries the LogFields of the thread that logs, so the
// logger must not be asynchronous.
std::unique_ptr<spdlog::formatter> MakeLogFormatter(LogFormat format);

}  // namespace motiondb::server
