// Reads tokens, numbers, lines and cells from a text file in memory, in one pass and without
// copies. Lines end in LF, CRLF or a lone CR, mixed at will; bytes need not be UTF-8; a UTF-8 byte
// order mark is skipped. Errors read "walk.bvh:12: expected a number, found 'abc'".
//
// Views returned point into the file's bytes, which the caller keeps. Thread-compatible.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/format/motion_file.h"
#include "core/motion/error.h"

namespace motiondb::core {

// The number that is all of `token`: "1e-5", "+3", ".0083", "5.". Nothing for anything else: nan,
// inf, "1.2abc", or a size beyond 1e18, which no file of motion means (and a float can still
// square).
std::optional<double> ParseNumber(std::string_view token);

// Whether `token` is the keyword (given in lower case) in any letter case.
bool IsKeyword(std::string_view token, std::string_view lower_case_keyword);

class TextScanner {
 public:
  // Each character of `punctuation` is a token by itself.
  explicit TextScanner(SourceFile file, std::string_view punctuation = "");

  // True if only white space is left, which it skips.
  bool AtEnd();
  // The next token on this or a later line; empty at the end of the file.
  std::string_view Token();
  // The next token on this line; empty at its end, which it does not pass.
  std::string_view TokenOnLine();
  // What is left of this line up to (and not past) the first of `stops`, trimmed. If none of them
  // stops it, passes the line's end.
  std::string_view RestOfLine(std::string_view stops = "");
  // The rest of this line (not trimmed), without passing it.
  std::string_view PeekLine() const;
  // The rest of this line (not trimmed), which it passes.
  std::string_view Line();
  // Skips blank lines, to the very start of the next; false at the end of the file.
  bool SkipBlankLines();
  // Skips blank lines and those whose first character is `comment`; false at the end of the file.
  bool NextLine(char comment);

  // The next token (on this line) as a number, or false; LastRead() then tells what was found.
  bool TryNumber(double& value);
  bool TryNumberOnLine(double& value);
  // The token that was read last.
  std::string_view LastRead() const;

  // The next token as a number; `what` names it in the error, which is at the line where the number
  // is missing or wrong.
  absl::Status ReadNumber(std::string_view what, double& value);
  // The next token as a whole number from `least` to `most`.
  absl::Status ReadInteger(std::string_view what, int least, int most, int& value);
  // The next token must be this keyword (given in lower case).
  absl::Status ReadKeyword(std::string_view lower_case_keyword);

  // An error at the line of the last token or line read.
  template <typename... Args>
  absl::Status Error(fmt::format_string<Args...> format, Args&&... args) const {
    return ErrorText(fmt::format(format, std::forward<Args>(args)...));
  }
  // "expected WHAT, found 'FOUND'"; an empty `found` is an end of line or of the file.
  absl::Status Expected(std::string_view what, std::string_view found) const;

  // Bytes not read yet: a bound on what the rest of the file can hold.
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - next_); }
  std::string_view rest() const { return {next_, bytes_left()}; }
  // True if the last byte is part of a token: the file may have been cut short within it.
  bool EndsInToken() const;

 private:
  absl::Status ErrorText(std::string_view text) const;
  int Line() const;  // from 1; O(file), for errors only
  void SkipBlanks();
  void PassLineEnd();
  void SkipWhiteSpace();
  bool AtTokenEnd(const char* p) const;
  void SkipToTokenEnd();
  std::string_view TakeToken();
  bool TakeNumber(double& value);

  std::string_view name_;
  std::string_view punctuation_;
  const char* begin_;
  const char* next_;
  const char* end_;
  const char* last_;  // start of what was read last
};

// `text` for an error message: valid UTF-8, no display controls, at most 40 bytes of it.
std::string Shown(std::string_view text);

// Words that white space separates: at least as many as the text has numbers.
std::size_t CountWords(std::string_view text);

// A note for the report if the file's last number may have lost digits, as nothing else can tell.
std::optional<std::string> NoteOnFileEnd(const TextScanner& scanner);

// Names as files have them, in whatever encoding their writer's machine used -> UTF-8, distinct
// within a file.

// `bytes` as they are if they are valid UTF-8, or else read as Latin-1. Display controls become
// '?'. The result is always valid UTF-8.
std::string ToUtf8(std::string_view bytes);

class UniqueNames {
 public:
  // `name` as UTF-8, cut to 255 bytes, with "_2", "_3" ... added if it was taken before.
  std::string Add(std::string_view name);

  // The names that had to change, as a note for the report; empty if none had to.
  std::string Note() const;

 private:
  std::unordered_map<std::string, int> taken_;  // and how far each has been numbered
  std::vector<std::string> changed_;
};

}  // namespace motiondb::core
