// UTF-8. Texts of files and of clients need not be valid; protobuf strings must be. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace motiondb::text {

inline constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: the text does not begin with well-formed UTF-8
};

// The first character of a text that is not empty (Unicode, table 3-7).
Character FirstCharacter(std::string_view text);

// Whether the text is well-formed UTF-8.
bool IsUtf8(std::string_view text);

// Whether a byte is the second or a later one of a character.
bool ContinuesCharacter(char byte);

// The text up to the last end of a character within its first `most` bytes.
std::string_view CutAt(std::string_view text, std::size_t most);

// The text with every byte that is not part of valid UTF-8 replaced by U+FFFD.
std::string ValidUtf8(std::string_view text);

// The same, cut to at most `limit` bytes, which are 3 or more, with "..." if something was cut.
std::string ValidUtf8(std::string_view text, std::size_t limit);

}  // namespace motiondb::text
