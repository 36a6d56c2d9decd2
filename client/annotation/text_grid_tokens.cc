#include "client/annotation/text_grid_tokens.h"

#include <fmt/format.h>

#include "client/annotation/formats.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::client {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

// Converts UTF-16 without its byte-order mark; false if it is not well-formed.
bool ConvertUtf16(std::string_view bytes, bool is_big_endian, std::string& text) {
  if (bytes.size() % 2 != 0) return false;
  char32_t high = 0;  // a surrogate that waits for the second one
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]);
    const auto second = static_cast<unsigned char>(bytes[i + 1]);
    const char32_t unit = is_big_endian ? first << 8 | second : second << 8 | first;
    const bool is_low = unit >= 0xDC00 && unit < 0xE000;
    if (is_low != (high != 0)) return false;
    if (unit >= 0xD800 && unit < 0xDC00) {
      high = unit;
      continue;
    }
    text::AppendUtf8(is_low ? 0x10000 + ((high - 0xD800) << 10) + (unit - 0xDC00) : unit, text);
    high = 0;
  }
  return high == 0;
}

}  // namespace

absl::StatusOr<std::string> DecodePraatText(std::string_view file_name, std::string_view bytes) {
  const bool is_big_endian = bytes.starts_with("\xFE\xFF");
  if (is_big_endian || bytes.starts_with("\xFF\xFE")) {
    std::string text;
    if (ConvertUtf16(bytes.substr(2), is_big_endian, text)) return text;
    return absl::InvalidArgumentError(
        fmt::format("{}: expected UTF-16, found an invalid character", file_name));
  }
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  if (text::IsUtf8(bytes)) return std::string(bytes);
  return absl::InvalidArgumentError(
      fmt::format("{}: expected UTF-8, or UTF-16 with a byte-order mark", file_name));
}

TextGridTokens::TextGridTokens(std::string_view file_name, std::string_view text)
    : file_name_(file_name), rest_(text) {}

std::string TextGridTokens::Place() const { return fmt::format("{}:{}", file_name_, token_line_); }

char TextGridTokens::TakeCharacter() {
  const char c = rest_.front();
  rest_.remove_prefix(1);
  if (c == '\n') ++line_;
  return c;
}

TextGridTokens::Token TextGridTokens::TakeQuoted() {
  Token token{.kind = Kind::kText};
  TakeCharacter();
  while (!rest_.empty()) {
    const char c = TakeCharacter();
    if (c == '"') {
      if (!rest_.starts_with('"')) return token;
      TakeCharacter();  // a doubled quote is a quote
    }
    token.text += c;
  }
  token.kind = Kind::kUnclosed;
  return token;
}

TextGridTokens::Token TextGridTokens::Take() {
  while (!rest_.empty()) {
    token_line_ = line_;
    if (kSpace.find(rest_.front()) != std::string_view::npos) {
      TakeCharacter();
    } else if (rest_.front() == '!') {
      rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
    } else if (rest_.front() == '"') {
      return TakeQuoted();
    } else {
      const std::size_t end = std::min(rest_.find_first_of(" \t\r\n\""), rest_.size());
      const std::string_view word = rest_.substr(0, end);
      rest_.remove_prefix(end);
      if (const auto number = ParseFiniteNumber(word)) {
        return {Kind::kNumber, std::string(word), *number};
      }
      if (word.starts_with('<') && word.ends_with('>')) return {Kind::kFlag, std::string(word), 0};
    }
  }
  token_line_ = line_;
  return {};
}

absl::Status TextGridTokens::Unexpected(const char* field, const char* expected,
                                        const Token& found) const {
  const std::string what = found.kind == Kind::kEnd        ? "the end of the file"
                           : found.kind == Kind::kUnclosed ? "a text without closing quote"
                           : found.kind == Kind::kText     ? "a text"
                                                           : text::SafeText(found.text);
  return absl::InvalidArgumentError(
      fmt::format("{}: {}: expected {}, found {}", Place(), field, expected, what));
}

absl::StatusOr<std::string> TextGridTokens::Text(const char* field) {
  Token token = Take();
  if (token.kind == Kind::kText) return std::move(token.text);
  return Unexpected(field, "a text in quotes", token);
}

absl::StatusOr<double> TextGridTokens::Number(const char* field) {
  const Token token = Take();
  if (token.kind == Kind::kNumber) return token.number;
  return Unexpected(field, "a number", token);
}

absl::StatusOr<std::string> TextGridTokens::Flag(const char* field) {
  Token token = Take();
  if (token.kind == Kind::kFlag) return std::move(token.text);
  return Unexpected(field, "<exists> or <absent>", token);
}

}  // namespace motiondb::client
