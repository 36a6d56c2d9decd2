#include "text/display_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "absl/strings/ascii.h"

namespace motiondb::text {
namespace {

// Characters that end a token in a text. A secret contains none of them.
constexpr std::string_view kTokenEnds = " \t\r\n/'\"`,;:@()[]{}<>";

std::string WithoutControls(std::string_view text, std::string_view replacement,
                            bool keep_line_feeds) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    const bool keep = character.bytes > 0 && (!IsDisplayControl(character.code) ||
                                              (character.code == '\n' && keep_line_feeds));
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    shown += keep ? text.substr(0, bytes) : replacement;
    text.remove_prefix(bytes);
  }
  return shown;
}

}  // namespace

bool IsDisplayControl(char32_t character) {
  const auto in = [character](char32_t first, char32_t last) {
    return first <= character && character <= last;
  };
  return character < 0x20 || in(0x7F, 0x9F) || character == 0x061C || in(0x200E, 0x200F) ||
         in(0x2028, 0x202E) || in(0x2066, 0x206F) || character == 0xFEFF || in(0xFFF9, 0xFFFB) ||
         in(0xFFFE, 0xFFFF);
}

Character FindDisplayControl(std::string_view text) {
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    if (character.bytes > 0 && IsDisplayControl(character.code)) return character;
    text.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  return {};
}

std::string DisplayText(std::string_view text, std::string_view replacement) {
  return WithoutControls(text, replacement, false);
}

std::string DisplayLines(std::string_view text) {
  return WithoutControls(text, kReplacement, true);
}

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

std::string RedactSecrets(std::string_view text) {
  std::string shown;
  while (true) {
    const std::size_t begin = text.find(kTokenPrefix);
    if (begin == std::string_view::npos) return shown.append(text);
    const std::string_view id = text.substr(begin + kTokenPrefix.size(), 2 * kTokenIdBytes);
    const std::size_t end = begin + kTokenPrefix.size() + id.size() + 1;
    if (end > text.size() || text[end - 1] != '_' || !std::ranges::all_of(id, [](char c) {
          return absl::ascii_isxdigit(static_cast<unsigned char>(c));
        })) {
      // Not a token. The next prefix may begin within this one: skip one character.
      shown.append(text.substr(0, begin + 1));
      text.remove_prefix(begin + 1);
      continue;
    }
    shown.append(text.substr(0, end)).append("...");
    text.remove_prefix(std::min(text.find_first_of(kTokenEnds, end), text.size()));
  }
}

std::string SafeText(std::string_view text) { return DisplayText(RedactSecrets(text)); }

}  // namespace motiondb::text
