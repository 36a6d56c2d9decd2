#include "server/observability/log.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>

#include "text/display_text.h"

namespace motiondb::server {

void StartLog(LogFormat format, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("motiondbd"));
  spdlog::set_level(spdlog::level::from_str(level));
  spdlog::set_formatter(MakeLogFormatter(format));
}

void Tell(LogFormat format, const std::string& message) {
  if (format == LogFormat::kText) {
    std::fputs(fmt::format("motiondbd: {}\n", text::SafeText(message)).c_str(), stderr);
    return;
  }
  spdlog::memory_buf_t line;
  MakeLogFormatter(format)->format(
      spdlog::details::log_msg("motiondbd", spdlog::level::critical, message), line);
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace motiondb::server
