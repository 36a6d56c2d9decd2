// What the command line prints goes through here, and JSON through json_output.h: no string of a
// server or a file reaches a terminal with display controls in it (client/display_text.h).
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace motiondb::client {

// To standard output: text of several lines, each with its line end.
void PrintText(std::string_view text);

// To standard output: one line, without its line end, which a string in it does not end either.
void PrintLineText(std::string_view line);
template <typename... Args>
void PrintLine(fmt::format_string<Args...> format, Args&&... args) {
  PrintLineText(fmt::format(format, std::forward<Args>(args)...));
}

// To standard error: "motiondb: ..." and a line end. The secrets of tokens are left out.
void PrintError(std::string_view error);

}  // namespace motiondb::client
