#include "tests/eval/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace motiondb::tests {
namespace {

constexpr std::chrono::milliseconds kTerminalPause(100);
constexpr std::chrono::seconds kLogPause(15);

}  // namespace

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::Begin(const std::string& stage, int steps) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  steps_ = steps;
  done_ = 0;
  Show();
}

void Progress::Step() {
  const std::lock_guard lock(mutex_);
  ++done_;
  const auto pause = std::chrono::steady_clock::now() - shown_;
  if (terminal_ ? pause >= kTerminalPause : pause >= kLogPause) Show();
}

void Progress::Clear() {
  const std::lock_guard lock(mutex_);
  bar_.Clear();
}

void Progress::Show() {
  shown_ = std::chrono::steady_clock::now();
  const double fraction = steps_ == 0 ? 0 : static_cast<double>(done_) / steps_;
  if (terminal_) {
    bar_.Show(fraction, stage_);
  } else {
    fmt::print(stderr, "{:3.0f} %  {}\n", 100 * fraction, stage_);
  }
}

}  // namespace motiondb::tests
