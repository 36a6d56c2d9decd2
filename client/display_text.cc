#include "client/display_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "absl/strings/ascii.h"

namespace motiondb::client {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: not well-formed
};

// The first character of a text that is not empty (Unicode, table 3-7).
Character FirstCharacter(std::string_view text) {
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
  return overlong || surrogate || code > 0x10FFFF ? Character{} : Character{code, bytes};
}

std::string WithoutControls(std::string_view text, bool keep_line_feeds) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    const bool keep = character.bytes > 0 && (!IsDisplayControl(character.code) ||
                                              (character.code == '\n' && keep_line_feeds));
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    shown += keep ? text.substr(0, bytes) : kReplacement;
    text.remove_prefix(bytes);
  }
  return shown;
}

// As the server's log does (server/security/shown_text.h).
std::string WithoutSecrets(std::string_view text) {
  constexpr std::string_view kPrefix = "mdb_", kEnds = " \t\r\n/'\"`,;:@()[]{}<>";
  constexpr std::size_t kIdDigits = 12;
  std::string shown;
  while (true) {
    const std::size_t begin = text.find(kPrefix);
    if (begin == std::string_view::npos) return shown.append(text);
    const std::string_view id = text.substr(begin + kPrefix.size(), kIdDigits);
    const std::size_t secret = begin + kPrefix.size() + id.size() + 1;
    const bool is_token = secret <= text.size() && text[secret - 1] == '_' &&
                          std::all_of(id.begin(), id.end(), [](char c) {
                            return absl::ascii_isxdigit(static_cast<unsigned char>(c));
                          });
    shown.append(text.substr(0, is_token ? secret : begin + 1));
    if (is_token) shown.append("...");
    text.remove_prefix(is_token ? std::min(text.find_first_of(kEnds, secret), text.size())
                                : begin + 1);
  }
}

}  // namespace

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    if (character.bytes == 0) return false;
    text.remove_prefix(character.bytes);
  }
  return true;
}

bool IsDisplayControl(char32_t character) {
  const auto in = [character](char32_t first, char32_t last) {
    return first <= character && character <= last;
  };
  return character < 0x20 || in(0x7F, 0x9F) || character == 0x061C || in(0x200E, 0x200F) ||
         in(0x2028, 0x202E) || in(0x2066, 0x206F) || character == 0xFEFF || in(0xFFF9, 0xFFFB) ||
         in(0xFFFE, 0xFFFF);
}

std::string DisplayText(std::string_view text) { return WithoutControls(text, false); }

std::string DisplayLines(std::string_view text) { return WithoutControls(text, true); }

std::string ErrorText(std::string_view text) { return DisplayText(WithoutSecrets(text)); }

std::string EscapedJson(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  while (!json.empty()) {
    const Character character = FirstCharacter(json);
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    if (character.bytes > 0 && IsDisplayControl(character.code) && character.code != '\n') {
      fmt::format_to(std::back_inserter(escaped), "\\u{:04x}",
                     static_cast<std::uint32_t>(character.code));
    } else {
      escaped += character.bytes > 0 ? json.substr(0, bytes) : kReplacement;
    }
    json.remove_prefix(bytes);
  }
  return escaped;
}

}  // namespace motiondb::client
