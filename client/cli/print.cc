#include "client/cli/print.h"

#include <cstdio>

#include "client/display_text.h"

namespace motiondb::client {

void PrintText(std::string_view text) { fmt::print("{}", DisplayLines(text)); }

void PrintLineText(std::string_view line) { fmt::print("{}\n", DisplayText(line)); }

void PrintError(std::string_view error) { fmt::print(stderr, "motiondb: {}\n", ErrorText(error)); }

}  // namespace motiondb::client
