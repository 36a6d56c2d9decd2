#include "server/translate/utf8.h"

#include <cstdint>

#include "core/format/text_encoding.h"

namespace motiondb::server {

std::string ValidUtf8(std::string_view text) {
  std::string valid;
  valid.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = core::FirstUtf8Character(text).bytes;
    if (length == 0) {
      valid += "\uFFFD";
      text.remove_prefix(1);
    } else {
      valid += text.substr(0, length);
      text.remove_prefix(length);
    }
  }
  return valid;
}

std::string ValidUtf8(std::string_view text, std::size_t limit) {
  std::string valid = ValidUtf8(text);
  if (valid.size() <= limit) return valid;
  constexpr std::string_view kCut = "...";
  std::size_t end = limit - kCut.size();
  while (end > 0 && (static_cast<std::uint8_t>(valid[end]) & 0xc0) == 0x80) --end;
  valid.resize(end);
  return valid.append(kCut);
}

}  // namespace motiondb::server
