#include "client/cli/utf8.h"

#include <cstddef>
#include <cstdint>

namespace motiondb::client {
namespace {

// Bytes that follow a first byte, or -1 if none can begin with it.
int FollowingBytes(uint8_t first) {
  if (first < 0x80) return 0;
  if (first >= 0xC2 && first < 0xE0) return 1;
  if (first >= 0xE0 && first < 0xF0) return 2;
  if (first >= 0xF0 && first < 0xF5) return 3;
  return -1;
}

// Long forms of short characters, surrogates, and what lies beyond U+10FFFF begin well but go on
// so.
bool IsForbidden(uint8_t first, uint8_t second) {
  return (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
         (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
}

}  // namespace

bool IsUtf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto first = static_cast<uint8_t>(text[i]);
    const int following = FollowingBytes(first);
    if (following < 0 || text.size() - i <= static_cast<size_t>(following)) return false;
    for (int k = 1; k <= following; ++k) {
      const auto next = static_cast<uint8_t>(text[i + static_cast<size_t>(k)]);
      if ((next & 0xC0) != 0x80 || (k == 1 && IsForbidden(first, next))) return false;
    }
    i += static_cast<size_t>(following) + 1;
  }
  return true;
}

}  // namespace motiondb::client
