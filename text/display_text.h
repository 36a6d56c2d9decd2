// Safe text for output: terminal, picture, JSON, log, error. Strings from clients, servers, files
// or the command line may contain access tokens, or characters that move a cursor, change the
// writing direction or end a line. These functions remove them.
#pragma once

#include <string>
#include <string_view>

#include "text/utf8.h"

namespace motiondb::text {

// Returns whether a character is a display control: C0 and C1 controls with DEL, line and paragraph
// separators, marks and overrides of the writing direction, deprecated format characters, the byte
// order mark, interlinear annotations, and the noncharacters that XML forbids.
bool IsDisplayControl(char32_t character);

// Returns the first display control of a valid UTF-8 text; a character of 0 bytes if it has none.
Character FindDisplayControl(std::string_view text);

// Returns one line: replaces each display control and each invalid UTF-8 byte by `replacement`.
std::string DisplayText(std::string_view text, std::string_view replacement = kReplacement);

// As DisplayText, but keeps line feeds.
std::string DisplayLines(std::string_view text);

// Returns JSON with the same values: writes each display control except line feeds as \uXXXX.
std::string EscapedJson(std::string_view json);

// A bearer token is `mdb_{id}_{secret}`; the id has 2 * kTokenIdBytes hexadecimal digits.
inline constexpr std::string_view kTokenPrefix = "mdb_";
inline constexpr int kTokenIdBytes = 6;

// Replaces the secrets of tokens in the text by "...". A secret, also an incomplete one, follows
// the prefix and id of a token and ends at white space, a quote, a bracket, or one of "/,;:@".
std::string RedactSecrets(std::string_view text);

// Returns one line without secrets and display controls, for errors and logs.
std::string SafeText(std::string_view text);

}  // namespace motiondb::text
