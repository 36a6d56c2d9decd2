#include "storage/postgres/postgres_text.h"

#include <cstddef>

namespace motiondb::storage {
namespace {

constexpr char kEscape = '\x01';
constexpr std::string_view kDigits = "0123456789abcdef";

unsigned ByteAt(std::string_view bytes, std::size_t place) {
  return place < bytes.size() ? static_cast<unsigned char>(bytes[place]) : 0;
}

// Returns the length of the character at the beginning; 0 if it is not valid UTF-8 (Unicode 15,
// table 3-7).
std::size_t CharacterLength(std::string_view bytes) {
  const unsigned first = ByteAt(bytes, 0);
  if (first < 0x80) return 1;
  std::size_t length = 0;
  unsigned low = 0x80;  // limits of the second byte
  unsigned high = 0xbf;
  if (first >= 0xc2 && first <= 0xdf) {
    length = 2;
  } else if (first >= 0xe0 && first <= 0xef) {
    length = 3;
    if (first == 0xe0) low = 0xa0;
    if (first == 0xed) high = 0x9f;
  } else if (first >= 0xf0 && first <= 0xf4) {
    length = 4;
    if (first == 0xf0) low = 0x90;
    if (first == 0xf4) high = 0x8f;
  }
  if (length == 0 || ByteAt(bytes, 1) < low || ByteAt(bytes, 1) > high) return 0;
  for (std::size_t i = 2; i < length; ++i) {
    if ((ByteAt(bytes, i) & 0xc0) != 0x80) return 0;
  }
  return length;
}

}  // namespace

std::string ToPostgresText(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  while (!bytes.empty()) {
    std::size_t length = CharacterLength(bytes);
    if (length == 0) {
      length = 1;
      const unsigned byte = ByteAt(bytes, 0);
      text += {kEscape, '2', kDigits[byte >> 4], kDigits[byte & 15]};
    } else if (bytes[0] == '\0' || bytes[0] == kEscape) {
      text += {kEscape, bytes[0] == '\0' ? '0' : '1'};
    } else {
      text += bytes.substr(0, length);
    }
    bytes.remove_prefix(length);
  }
  return text;
}

std::string FromPostgresText(std::string_view text) {
  if (text.find(kEscape) == std::string_view::npos) return std::string(text);
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != kEscape) {
      bytes += text[i];
      continue;
    }
    const unsigned kind = ByteAt(text, ++i);
    if (kind == '2') {
      const std::size_t high = kDigits.find(static_cast<char>(ByteAt(text, i + 1)));
      const std::size_t low = kDigits.find(static_cast<char>(ByteAt(text, i + 2)));
      bytes += static_cast<char>(((high & 15) << 4) | (low & 15));
      i += 2;
    } else {
      bytes += kind == '0' ? '\0' : kEscape;
    }
  }
  return bytes;
}

}  // namespace motiondb::storage
