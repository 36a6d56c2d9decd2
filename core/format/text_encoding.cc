#include "core/format/text_encoding.h"

#include <cstdint>

namespace motiondb::core {
namespace {

std::uint8_t Byte(char c) { return static_cast<std::uint8_t>(c); }

// The length of the UTF-8 sequence that begins `bytes`, or 0 if it is not well-formed.
std::size_t SequenceLength(std::string_view bytes) {
  const std::uint8_t first = Byte(bytes[0]);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || bytes.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((Byte(bytes[i]) & 0xC0) != 0x80) return 0;
  }
  const std::uint8_t second = Byte(bytes[1]);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second >= 0xA0;
  const bool too_large = first == 0xF4 && second >= 0x90;
  return overlong || surrogate || too_large ? 0 : length;
}

bool IsUtf8(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t length = SequenceLength(bytes);
    if (length == 0) return false;
    bytes.remove_prefix(length);
  }
  return true;
}

}  // namespace

std::string ToUtf8(std::string_view bytes) {
  const bool is_utf8 = IsUtf8(bytes);
  std::string text;
  text.reserve(bytes.size());
  for (const char c : bytes) {
    if (Byte(c) < 0x20 || Byte(c) == 0x7F) {
      text += '?';
    } else if (Byte(c) < 0x80 || is_utf8) {
      text += c;
    } else {
      text += static_cast<char>(0xC0 | (Byte(c) >> 6));
      text += static_cast<char>(0x80 | (Byte(c) & 0x3F));
    }
  }
  return text;
}

}  // namespace motiondb::core
