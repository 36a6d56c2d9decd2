// Captures the server's log during a test.
#pragma once

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>

#include "server/observability/log.h"

namespace motiondb::tests {

// Replaces the default logger until destroyed.
class CapturedLog {
 public:
  explicit CapturedLog(spdlog::level::level_enum level) : former_(spdlog::default_logger()) {
    auto logger = std::make_shared<spdlog::logger>(
        "captured", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_));
    logger->set_formatter(server::MakeLogFormatter(server::LogFormat::kJson));
    logger->set_level(level);
    spdlog::set_default_logger(logger);
  }
  ~CapturedLog() { spdlog::set_default_logger(former_); }

  // Returns the captured JSON lines. Call only after all logging threads have ended.
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  const std::shared_ptr<spdlog::logger> former_;
};

}  // namespace motiondb::tests
