#include "core/format/text_encoding.h"

#include <cstdint>

#include "text/display_text.h"

namespace motiondb::core {
namespace {

std::string FromLatin1(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<std::uint8_t>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0 | (byte >> 6));
      text += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return text;
}

}  // namespace

std::string ToUtf8(std::string_view bytes) {
  return text::DisplayText(text::IsUtf8(bytes) ? std::string(bytes) : FromLatin1(bytes), "?");
}

}  // namespace motiondb::core
