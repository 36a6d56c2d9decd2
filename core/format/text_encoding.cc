#include "core/format/text_encoding.h"

#include <algorithm>
#include <cstdint>

namespace motiondb::core {
namespace {

bool IsUtf8(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t length = FirstUtf8Character(bytes).bytes;
    if (length == 0) return false;
    bytes.remove_prefix(length);
  }
  return true;
}

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

// With `replacement` for display controls and for bytes that are not UTF-8.
std::string Replaced(std::string_view text, std::string_view replacement) {
  std::string plain;
  plain.reserve(text.size());
  while (!text.empty()) {
    const Utf8Character character = FirstUtf8Character(text);
    const bool keep = character.bytes > 0 && !IsDisplayControl(character.code);
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    plain += keep ? text.substr(0, bytes) : replacement;
    text.remove_prefix(bytes);
  }
  return plain;
}

}  // namespace

Utf8Character FirstUtf8Character(std::string_view text) {
  const auto first = static_cast<std::uint8_t>(text[0]);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return {};
  char32_t code = first & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<std::uint8_t>(text[i]);
    if ((next & 0xC0) != 0x80) return {};
    code = (code << 6) | (next & 0x3FU);
  }
  const bool overlong = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return overlong || surrogate || code > 0x10FFFF ? Utf8Character{} : Utf8Character{code, bytes};
}

bool IsDisplayControl(char32_t character) {
  const auto in = [character](char32_t first, char32_t last) {
    return first <= character && character <= last;
  };
  return character < 0x20 || in(0x7F, 0x9F) || character == 0x061C || in(0x200E, 0x200F) ||
         in(0x2028, 0x202E) || in(0x2066, 0x206F) || character == 0xFEFF || in(0xFFF9, 0xFFFB) ||
         in(0xFFFE, 0xFFFF);
}

Utf8Character FindDisplayControl(std::string_view text) {
  while (!text.empty()) {
    const Utf8Character character = FirstUtf8Character(text);
    if (character.bytes > 0 && IsDisplayControl(character.code)) return character;
    text.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  return {};
}

std::string WithoutDisplayControls(std::string_view text) {
  return Replaced(text, "\xEF\xBF\xBD");  // U+FFFD
}

std::string ToUtf8(std::string_view bytes) {
  return Replaced(IsUtf8(bytes) ? std::string(bytes) : FromLatin1(bytes), "?");
}

}  // namespace motiondb::core
