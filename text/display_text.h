// Text for people: a terminal, a picture, JSON, a log, an error. Strings of a client, a server, a
// file or the command line may hold characters that move a cursor, reverse the order of the text
// around them or end a line, and access tokens: none of these reaches an output. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "text/utf8.h"

namespace motiondb::text {

// Whether a character is a display control: C0 and C1 controls with DEL, line and paragraph
// separators, marks and overrides of the writing direction, deprecated format characters, the byte
// order mark, interlinear annotation, and the noncharacters that XML forbids.
bool IsDisplayControl(char32_t character);

// The first display control of a valid UTF-8 text; 0 bytes if it has none.
Character FindDisplayControl(std::string_view text);

// One line: `replacement` for each display control, and for each byte that is not UTF-8.
std::string DisplayText(std::string_view text, std::string_view replacement = kReplacement);

// As DisplayText, but line feeds stay.
std::string DisplayLines(std::string_view text);

// JSON with the same values: each display control but a line feed as \uXXXX.
std::string EscapedJson(std::string_view json);

// A bearer token is `mdb_{id}_{secret}`; its id has twice as many hexadecimal digits as bytes.
inline constexpr std::string_view kTokenPrefix = "mdb_";
inline constexpr int kTokenIdBytes = 6;

// The text with "..." for whatever follows the id of what looks like a token in it, whole or in
// part, up to white space, a quote, a bracket, or one of "/,;:@".
std::string WithoutSecrets(std::string_view text);

// For errors and logs: one line without secrets and display controls.
std::string SafeText(std::string_view text);

}  // namespace motiondb::text
