// The log of the code under test, to wait for what it reports.
#pragma once

#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

namespace motiondb::tests {

// Replaces the default logger, and must outlive its users. Keeps the last 100 lines.
class AwaitedLog {
 public:
  AwaitedLog() { spdlog::set_default_logger(std::make_shared<spdlog::logger>("awaited", lines_)); }
  ~AwaitedLog() { spdlog::set_default_logger(former_); }

  // Waits for `count` lines with `text`; false after a minute.
  bool Await(const std::string& text, int count = 1) const {
    const auto has_text = [&](const std::string& line) {
      return line.find(text) != std::string::npos;
    };
    const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < latest) {
      if (std::ranges::count_if(lines_->last_formatted(), has_text) >= count) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

 private:
  const std::shared_ptr<spdlog::logger> former_ = spdlog::default_logger();
  const std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(100);
};

}  // namespace motiondb::tests
