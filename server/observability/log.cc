#include "server/observability/log.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>

namespace motiondb::server {

void StartLog(LogFormat format, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("motiondbd"));
  spdlog::set_level(spdlog::level::from_str(level));
  spdlog::set_formatter(MakeLogFormatter(format));
}

void Tell(LogFormat format, const std::string& message) {
  if (format == LogFormat::kText) {
    fmt::print(stderr, "motiondbd: {}\n", message);
    return;
  }
  spdlog::memory_buf_t line;
  MakeLogFormatter(format)->format(
      spdlog::details::log_msg("motiondbd", spdlog::level::critical, message), line);
  fmt::print(stderr, "{}", std::string(line.data(), line.size()));
}

}  // namespace motiondb::server
