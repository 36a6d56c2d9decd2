// The values in the text of a Praat file. Long and short files have the same values in the same
// order; everything else is a comment (Praat manual, "TextGrid file formats").
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// Returns the text as UTF-8. The bytes are UTF-8, or UTF-16 with a byte-order mark.
// INVALID_ARGUMENT: neither.
absl::StatusOr<std::string> DecodePraatText(std::string_view file_name, std::string_view bytes);

class TextGridTokens {
 public:
  // The text must outlive the reader.
  TextGridTokens(std::string_view file_name, std::string_view text);

  // Return the next value, which `field` describes: a text in quotes, a finite number, or a flag
  // such as "<exists>". INVALID_ARGUMENT with file, line and field: another value, or the end.
  absl::StatusOr<std::string> Text(const char* field);
  absl::StatusOr<double> Number(const char* field);
  absl::StatusOr<std::string> Flag(const char* field);

  // "FILE:LINE" of the last value.
  std::string Place() const;

 private:
  enum class Kind { kEnd, kText, kNumber, kFlag, kUnclosed };
  struct Token {
    Kind kind = Kind::kEnd;
    std::string text;
    double number = 0;
  };

  Token Take();
  Token TakeQuoted();
  char TakeCharacter();
  absl::Status Unexpected(const char* field, const char* expected, const Token& found) const;

  const std::string file_name_;
  std::string_view rest_;
  int line_ = 1;        // at the beginning of rest_
  int token_line_ = 1;  // of the last token
};

}  // namespace motiondb::client
