// Lines and words of a marker-set file.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::core {

struct Token {
  std::string text;
  bool quoted = false;  // a quoted token is always a name
};

// Splits a line at blanks. "..." quotes a name with blanks; "" inside it is a quote; # starts a
// comment. INVALID_ARGUMENT if a quote is not closed.
absl::StatusOr<std::vector<Token>> Tokens(std::string_view line);

// Removes the first line, with its end, from `text` and returns it without its end.
std::string_view NextLine(std::string_view& text);

// Returns the value of a finite number without quotes.
std::optional<double> Number(const Token& token);

// Returns the name, in quotes if the format needs them.
std::string QuotedName(const std::string& name);

}  // namespace motiondb::core
