// The terminal behind a standard stream: its size, and styles of text on it.
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

}  // namespace motiondb::client
