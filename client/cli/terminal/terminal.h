// The terminal behind a standard stream: its size, styles of text on it, and a progress bar.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

namespace motiondb::client {

// Size in characters; without limits if the stream is not a terminal.
struct TerminalSize {
  static constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();
  std::size_t columns = kUnlimited;
  std::size_t rows = kUnlimited;
};

// `descriptor`: STDOUT_FILENO or STDERR_FILENO. A terminal that does not tell its size has 80 x 24.
TerminalSize SizeOfTerminal(int descriptor);

// Whether the stream is a terminal with colours, and NO_COLOR (https://no-color.org) is not set.
bool HasColours(int descriptor);

enum class Style { kPlain, kHeading, kGood, kWarning, kError };

// Marks text for WithStyles. The text is at most one line. Marks have no width.
std::string Styled(Style style, std::string_view text);

// Returns the text for display: control characters are replaced (text::DisplayLines), and marks
// become colours, or nothing. A text that contains marks itself, as one from a server can, changes
// at most colours.
std::string WithStyles(std::string_view text, bool has_colours);

// A progress bar on standard error. Shows nothing if standard error is not a terminal.
class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  // clears the line

  // Draws the bar with `fraction` (0 to 1) and the current activity.
  void Show(double fraction, const std::string& activity);

  // Removes the bar, so that other lines can be printed.
  void Clear();

 private:
  const bool enabled_;
  bool shown_ = false;
};

// Returns the line that Show draws, at most `columns` characters.
std::string ProgressLine(double fraction, const std::string& activity, int columns);

}  // namespace motiondb::client
