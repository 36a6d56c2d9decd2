#include "client/cli/terminal/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "client/cli/terminal/terminal.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

constexpr int kBarCells = 24;

}  // namespace

std::string ProgressLine(double fraction, const std::string& activity, int columns) {
  const double shown = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(shown * kBarCells);
  const std::string line =
      fmt::format("[{}{}] {:3.0f} %  {}", std::string(filled, '#'),
                  std::string(kBarCells - filled, '.'), shown * 100, text::DisplayText(activity));
  return std::string(text::TruncateUtf8(line, static_cast<std::size_t>(std::max(columns - 1, 0))));
}

ProgressBar::ProgressBar() : enabled_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() { Clear(); }

void ProgressBar::Show(double fraction, const std::string& activity) {
  if (!enabled_) return;
  fmt::print(
      stderr, "\r\033[K{}",
      ProgressLine(fraction, activity, static_cast<int>(SizeOfTerminal(STDERR_FILENO).columns)));
  std::fflush(stderr);
  shown_ = true;
}

void ProgressBar::Clear() {
  if (!shown_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace motiondb::client
