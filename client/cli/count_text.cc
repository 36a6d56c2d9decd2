#include "client/cli/count_text.h"

#include <fmt/format.h>

namespace motiondb::client {

std::string CountText(std::int64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace motiondb::client
