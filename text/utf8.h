// UTF-8. Texts from files and clients may be invalid; protobuf strings must be valid.
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

// Returns the first character of a non-empty text (Unicode, table 3-7).
Character FirstCharacter(std::string_view text);

// Appends the UTF-8 of a character. REQUIRES: `code` is a Unicode scalar value, so no surrogate.
void AppendUtf8(char32_t code, std::string& text);

// Returns whether the text is well-formed UTF-8.
bool IsUtf8(std::string_view text);

// Returns the text with the letters A to Z in lower case; other characters are unchanged.
std::string LowerCase(std::string_view text);

// Returns whether a byte is a continuation byte of a character.
bool IsContinuationByte(char byte);

// Returns the longest prefix of whole characters with at most `max_bytes` bytes.
std::string_view TruncateUtf8(std::string_view text, std::size_t max_bytes);

// Returns the text with each invalid byte replaced by U+FFFD.
std::string ValidUtf8(std::string_view text);

// As above, cut to at most `limit` bytes (at least 3); ends with "..." if it was cut.
std::string ValidUtf8(std::string_view text, std::size_t limit);

}  // namespace motiondb::text
