// Reads tokens, numbers and lines from a text file in memory, in one pass without copies. Lines end
// in LF, CRLF or CR, also mixed; bytes need not be UTF-8; a UTF-8 byte order mark is skipped.
// Errors have the form "walk.bvh:12: expected a number, found 'abc'".
//
// Returned views point into the file's bytes, which the caller keeps. Thread-compatible.
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

// Parses all of `token` as a number: "1e-5", "+3", ".0083", "5.". Returns nothing for other text:
// nan, inf, "1.2abc", or a magnitude above 1e18 (implausible; its square still fits a float).
std::optional<double> ParseNumber(std::string_view token);

// Compares `token` with a keyword (in lower case), ignoring case.
bool IsKeyword(std::string_view token, std::string_view lower_case_keyword);

class TextScanner {
 public:
  // Each character of `punctuation` is a separate token.
  explicit TextScanner(SourceFile file, std::string_view punctuation = "");

  // Skips white space. Returns true at the end of the file.
  bool AtEnd();
  // Returns the next token on this or a later line; empty at the end of the file.
  std::string_view Token();
  // Returns the next token on this line; empty at the end of the line, which it does not pass.
  std::string_view TokenOnLine();
  // Returns the rest of this line up to (not past) the first of `stops`, trimmed. Passes the line's
  // end if no stop is found.
  std::string_view RestOfLine(std::string_view stops = "");
  // Returns the rest of this line (not trimmed), without passing it.
  std::string_view PeekLine() const;
  // Returns the rest of this line (not trimmed) and passes it.
  std::string_view Line();
  // Skips blank lines, to the first character of the next line; false at the end of the file.
  bool SkipBlankLines();
  // Skips blank lines and those whose first character is `comment`; false at the end of the file.
  bool NextLine(char comment);

  // Reads the next token (on this line) as a number. If false, LastRead() returns the token.
  bool TryNumber(double& value);
  bool TryNumberOnLine(double& value);
  // The most recent token.
  std::string_view LastRead() const;

  // Reads the next token as a number. `what` names it in the error, whose line is that of the wrong
  // or missing number.
  absl::Status ReadNumber(std::string_view what, double& value);
  // Reads the next token as an integer from `least` to `most`.
  absl::Status ReadInteger(std::string_view what, int least, int most, int& value);
  // Reads the next token, which must be this keyword (in lower case).
  absl::Status ReadKeyword(std::string_view lower_case_keyword);

  // Returns an error at the line of the most recent token or line.
  template <typename... Args>
  absl::Status Error(fmt::format_string<Args...> format, Args&&... args) const {
    return ErrorText(fmt::format(format, std::forward<Args>(args)...));
  }
  // Returns "expected WHAT, found 'FOUND'"; an empty `found` means the end of the line or file.
  absl::Status Expected(std::string_view what, std::string_view found) const;

  // Number of unread bytes: an upper bound for sizes in the rest of the file.
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - next_); }
  std::string_view rest() const { return {next_, bytes_left()}; }
  // True if the last byte is part of a token: the file may be truncated.
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
  const char* last_;  // start of the most recent token or line
};

// Returns `text` for an error message: valid UTF-8, no display controls, at most 40 bytes.
std::string Shown(std::string_view text);

// Number of words separated by white space: an upper bound for the numbers in the text.
std::size_t CountWords(std::string_view text);

// Returns a note if the file's last number may be truncated, which nothing else can detect.
std::optional<std::string> NoteOnFileEnd(const TextScanner& scanner);

// Returns `bytes` unchanged if they are valid UTF-8, else converts from Latin-1. Replaces display
// controls by '?'. The result is always valid UTF-8.
std::string ToUtf8(std::string_view bytes);

// Makes names unique within a file.
class UniqueNames {
 public:
  // Returns `name` as UTF-8, cut to 255 bytes, with "_2", "_3" ... appended if it was used before.
  std::string Add(std::string_view name);

  // Returns a note for the report with the names that changed; empty if none did.
  std::string Note() const;

 private:
  std::unordered_map<std::string, int> taken_;  // with the last number of each
  std::vector<std::string> changed_;
};

}  // namespace motiondb::core
