#include "storage/postgres/postgres_text.h"

#include <cstddef>

#include "text/utf8.h"

namespace motiondb::storage {
namespace {

constexpr char kEscape = '\x01';
constexpr std::string_view kDigits = "0123456789abcdef";

unsigned ByteAt(std::string_view bytes, std::size_t place) {
  return place < bytes.size() ? static_cast<unsigned char>(bytes[place]) : 0;
}

}  // namespace

std::string ToPostgresText(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  while (!bytes.empty()) {
    std::size_t length = text::FirstCharacter(bytes).bytes;
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
