#include "client/cli/terminal/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include "text/display_text.h"

namespace motiondb::client {

namespace {

// Control characters, which no displayed text contains (text::DisplayText).
constexpr char kBegin = '\x0e';
constexpr char kEnd = '\x0f';

// Select Graphic Rendition, in order of Style.
constexpr std::array<std::string_view, 5> kCodes = {"\x1b[0m", "\x1b[1m", "\x1b[32m", "\x1b[33m",
                                                    "\x1b[31m"};

}  // namespace

TerminalSize SizeOfTerminal(int descriptor) {
  if (isatty(descriptor) != 1) return {};
  winsize size{};
  const bool is_known = ioctl(descriptor, TIOCGWINSZ, &size) == 0;
  return {is_known && size.ws_col > 0 ? size.ws_col : std::size_t{80},
          is_known && size.ws_row > 0 ? size.ws_row : std::size_t{24}};
}

bool HasColours(int descriptor) {
  const char* const refused = std::getenv("NO_COLOR");
  const char* const terminal = std::getenv("TERM");
  const bool is_plain = terminal == nullptr || std::string_view(terminal) == "dumb";
  return isatty(descriptor) == 1 && !is_plain && (refused == nullptr || *refused == '\0');
}

std::string Styled(Style style, std::string_view text) {
  if (style == Style::kPlain || text.empty()) return std::string(text);
  std::string marked = {kBegin, static_cast<char>('0' + static_cast<int>(style))};
  return marked.append(text) += kEnd;
}

std::string WithStyles(std::string_view text, bool has_colours) {
  std::string shown;
  bool is_open = false;
  const auto set = [&](std::size_t style) {
    if (has_colours && (style > 0 || is_open)) shown += kCodes[style];
    is_open = style > 0;
  };
  while (!text.empty()) {
    // A style ends with its line at the latest.
    const std::string_view stops = is_open ? "\x0e\x0f\n" : "\x0e\x0f";
    const std::size_t end = std::min(text.find_first_of(stops), text.size());
    shown += text::DisplayLines(text.substr(0, end));
    text.remove_prefix(end);
    if (text.empty()) break;
    const std::size_t style =
        text.size() > 1 ? static_cast<std::size_t>(static_cast<unsigned char>(text[1])) - '0' : 0;
    if (text.front() == kBegin && style > 0 && style < kCodes.size()) {
      set(style);
      text.remove_prefix(2);
    } else if (text.front() == kEnd && is_open) {
      set(0);
      text.remove_prefix(1);
    } else {  // a line feed, or a control character
      set(0);
      shown += text::DisplayLines(text.substr(0, 1));
      text.remove_prefix(1);
    }
  }
  set(0);
  return shown;
}

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
