// Text for a terminal, a picture or JSON. Strings of a server, a file or the command line may hold
// characters that move a cursor, reverse the order of the text around them, or end a line: none of
// these reaches an output. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::client {

// Whether the text is well-formed UTF-8. A message with any other text cannot be sent.
bool IsUtf8(std::string_view text);

// Whether a character is a display control: C0 and C1 controls with DEL, line and paragraph
// separators, marks and overrides of the writing direction, deprecated format characters, the byte
// order mark, interlinear annotation, and the noncharacters that XML forbids. The server rejects
// the same characters (core/format/text_encoding.h).
bool IsDisplayControl(char32_t character);

// One line: U+FFFD for each display control, and for each byte that is not UTF-8.
std::string DisplayText(std::string_view text);

// The same, but line feeds stay.
std::string DisplayLines(std::string_view text);

// For errors: tokens `mdb_ID_SECRET` without their secrets, then as DisplayText.
std::string ErrorText(std::string_view text);

// JSON with the same values: each display control but a line feed as \uXXXX.
std::string EscapedJson(std::string_view json);

}  // namespace motiondb::client
