#include "client/cli/print.h"

#include <cstdio>

#include "text/display_text.h"

namespace motiondb::client {

void PrintText(std::string_view text) { fmt::print("{}", text::DisplayLines(text)); }

void PrintLineText(std::string_view line) { fmt::print("{}\n", text::DisplayText(line)); }

void PrintError(std::string_view error) {
  fmt::print(stderr, "motiondb: {}\n", text::SafeText(error));
}

}  // namespace motiondb::client
