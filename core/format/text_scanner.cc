#include "core/format/text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::core {

namespace {

constexpr double kMaxNumber = 1e18;

constexpr std::array<double, 16> kPowersOfTen = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool IsLineEnd(char c) { return c == '\n' || c == '\r'; }
// IsBlank or IsLineEnd, without branches, so that compilers vectorize loops over it.
bool IsSpace(char c) {
  const auto from_tab = static_cast<unsigned char>(c - '\t');
  return (static_cast<int>(c == ' ') | static_cast<int>(from_tab <= '\r' - '\t')) != 0;
}
bool IsDigit(char c) { return c >= '0' && c <= '9'; }
char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Parses all forms of numbers with std::from_chars, plus a leading '+'.
bool ParseAnyNumber(const char* begin, const char* end, double& value) {
  const bool plus = begin < end && *begin == '+';
  if (plus) ++begin;
  const char* digits = !plus && begin < end && *begin == '-' ? begin + 1 : begin;
  if (digits == end || !(IsDigit(*digits) || *digits == '.')) return false;  // nan, inf, "+-1"
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (rest != end) return false;
  if (error == std::errc::result_out_of_range) {
    value = 0;  // underflow, or overflow if the exponent is positive
    const std::string_view text(begin, static_cast<std::size_t>(end - begin));
    return text.find("e-") != text.npos || text.find("E-") != text.npos;
  }
  return error == std::errc() && std::abs(value) <= kMaxNumber;
}

// Fast path for plain decimals of up to 15 digits, the usual numbers of motion files. Digits below
// 2^53 and powers of ten up to 22 are exact in a double, so one division rounds to nearest, as
// from_chars does. Returns the end of the number, or nullptr for other forms.
const char* ParsePlainDecimal(const char* begin, const char* end, double& value) {
  const char* p = begin;
  const bool negative = p < end && *p == '-';
  if (negative) ++p;
  const char* first = p;
  std::uint64_t digits = 0;
  while (p < end && IsDigit(*p)) digits = 10 * digits + static_cast<std::uint64_t>(*p++ - '0');
  auto count = p - first;
  std::ptrdiff_t decimals = 0;
  if (p < end && *p == '.') {
    first = ++p;
    while (p < end && IsDigit(*p)) digits = 10 * digits + static_cast<std::uint64_t>(*p++ - '0');
    decimals = p - first;
    count += decimals;
  }
  if (count == 0 || count > 15) return nullptr;
  const double magnitude = static_cast<double>(digits) / kPowersOfTen[decimals];
  value = negative ? -magnitude : magnitude;
  return p;
}

}  // namespace

std::optional<double> ParseNumber(std::string_view token) {
  if (token.empty()) return std::nullopt;
  const char* end = token.data() + token.size();
  double value = 0;
  if (ParsePlainDecimal(token.data(), end, value) == end) return value;
  if (ParseAnyNumber(token.data(), end, value)) return value;
  return std::nullopt;
}

bool IsKeyword(std::string_view token, std::string_view lower_case_keyword) {
  return std::equal(token.begin(), token.end(), lower_case_keyword.begin(),
                    lower_case_keyword.end(), [](char a, char b) { return Lower(a) == b; });
}

std::size_t CountWords(std::string_view text) {
  if (text.empty()) return 0;
  constexpr std::size_t kBlock = 255;  // a byte can count its words, so loops vectorize over bytes
  std::size_t words = IsSpace(text.front()) ? 0 : 1;
  for (std::size_t begin = 1; begin < text.size(); begin += kBlock) {
    const std::size_t size = std::min(kBlock, text.size() - begin);
    const char* const block = text.data() + begin;
    std::uint8_t starts = 0;
    for (std::size_t i = 0; i < size; ++i) {
      starts += static_cast<std::uint8_t>(IsSpace(block[i - 1]) > IsSpace(block[i]));
    }
    words += starts;
  }
  return words;
}

std::string Shown(std::string_view text) {
  constexpr std::size_t kMaxShown = 40;
  std::string shown = ToUtf8(text.substr(0, kMaxShown));
  return text.size() > kMaxShown ? shown + "..." : shown;
}

TextScanner::TextScanner(SourceFile file, std::string_view punctuation)
    : name_(file.name),
      punctuation_(punctuation),
      begin_(file.bytes.data()),
      next_(begin_),
      end_(begin_ + file.bytes.size()),
      last_(begin_) {
  if (file.bytes.starts_with("\xEF\xBB\xBF")) next_ += 3;
}

void TextScanner::SkipBlanks() {
  while (next_ < end_ && IsBlank(*next_)) ++next_;
}

bool TextScanner::SkipBlankLines() {
  const char* line = next_;
  SkipWhiteSpace();
  if (next_ == end_) return !AtEnd();
  while (next_ > line && IsBlank(next_[-1])) --next_;
  last_ = next_;
  return true;
}

bool TextScanner::AtTokenEnd(const char* p) const {
  return p == end_ || IsSpace(*p) || punctuation_.find(*p) != punctuation_.npos;
}

void TextScanner::SkipToTokenEnd() {
  while (!AtTokenEnd(next_)) ++next_;
}

std::string_view TextScanner::LastRead() const {
  return {last_, static_cast<std::size_t>(next_ - last_)};
}

void TextScanner::SkipWhiteSpace() {
  while (next_ < end_ && IsSpace(*next_)) ++next_;
}

bool TextScanner::AtEnd() {
  SkipWhiteSpace();
  last_ = next_;
  return next_ == end_;
}

std::string_view TextScanner::TakeToken() {
  last_ = next_;
  if (next_ < end_ && punctuation_.find(*next_) != punctuation_.npos) {
    ++next_;
  } else {
    SkipToTokenEnd();
  }
  return LastRead();
}

std::string_view TextScanner::Token() {
  SkipWhiteSpace();
  return TakeToken();
}

std::string_view TextScanner::TokenOnLine() {
  SkipBlanks();
  return TakeToken();
}

std::string_view TextScanner::PeekLine() const {
  return {next_, static_cast<std::size_t>(std::find_if(next_, end_, IsLineEnd) - next_)};
}

std::string_view TextScanner::Line() {
  const std::string_view line = PeekLine();
  last_ = next_;
  next_ += line.size();
  PassLineEnd();
  return line;
}

bool TextScanner::NextLine(char comment) {
  while (!AtEnd()) {
    if (*next_ != comment) return true;
    Line();
  }
  return false;
}

void TextScanner::PassLineEnd() {
  if (next_ == end_ || !IsLineEnd(*next_)) return;
  next_ += *next_ == '\r' && next_ + 1 < end_ && next_[1] == '\n' ? 2 : 1;
}

std::string_view TextScanner::RestOfLine(std::string_view stops) {
  SkipBlanks();
  last_ = next_;
  while (next_ < end_ && !IsLineEnd(*next_) && stops.find(*next_) == stops.npos) ++next_;
  const char* stop = next_;
  PassLineEnd();
  while (stop > last_ && IsBlank(stop[-1])) --stop;
  return {last_, static_cast<std::size_t>(stop - last_)};
}

bool TextScanner::TryNumber(double& value) {
  SkipWhiteSpace();
  return TakeNumber(value);
}

bool TextScanner::TryNumberOnLine(double& value) {
  SkipBlanks();
  return TakeNumber(value);
}

bool TextScanner::TakeNumber(double& value) {
  last_ = next_;
  const char* stop = ParsePlainDecimal(next_, end_, value);
  if (stop != nullptr && AtTokenEnd(stop)) {
    next_ = stop;
    return true;
  }
  SkipToTokenEnd();
  return ParseAnyNumber(last_, next_, value);
}

absl::Status TextScanner::ReadNumber(std::string_view what, double& value) {
  const char* const before = next_;
  if (TryNumber(value)) return absl::OkStatus();
  if (!std::any_of(before, last_, IsLineEnd)) return Expected(what, LastRead());
  next_ = last_ = before;  // report the line where it is missing
  return Expected(what, "");
}

absl::Status TextScanner::ReadInteger(std::string_view what, int least, int most, int& value) {
  double number = 0;
  MOTIONDB_RETURN_IF_ERROR(ReadNumber(what, number));
  if (number != std::floor(number) || number < least || number > most) {
    return Error("expected {} (a whole number from {} to {}), found '{}'", what, least, most,
                 Shown(LastRead()));
  }
  value = static_cast<int>(number);
  return absl::OkStatus();
}

absl::Status TextScanner::ReadKeyword(std::string_view lower_case_keyword) {
  const std::string_view token = Token();
  if (IsKeyword(token, lower_case_keyword)) return absl::OkStatus();
  std::string keyword(lower_case_keyword);
  std::transform(keyword.begin(), keyword.end(), keyword.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  return Expected(fmt::format("'{}'", keyword), token);
}

absl::Status TextScanner::Expected(std::string_view what, std::string_view found) const {
  if (!found.empty()) return Error("expected {}, found '{}'", what, Shown(found));
  const bool at_end = std::all_of(next_, end_, IsSpace);
  return at_end ? Error("the file ends here (truncated?), expected {}", what)
                : Error("the line ends here, expected {}", what);
}

int TextScanner::Line() const {
  int line = 1;
  for (const char* p = begin_; p < last_; ++p) {
    if (*p == '\n' || (*p == '\r' && (p + 1 == end_ || p[1] != '\n'))) ++line;
  }
  return line;
}

absl::Status TextScanner::ErrorText(std::string_view text) const {
  return InvalidArgument("{}:{}: {}", name_, Line(), text);
}

bool TextScanner::EndsInToken() const { return begin_ < end_ && !IsSpace(end_[-1]); }

std::optional<std::string> NoteOnFileEnd(const TextScanner& scanner) {
  if (!scanner.EndsInToken()) return std::nullopt;
  return "the file does not end with a line end: its last number may have been cut short";
}

namespace {

std::string FromLatin1(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) text::AppendUtf8(static_cast<unsigned char>(c), text);
  return text;
}

}  // namespace

std::string ToUtf8(std::string_view bytes) {
  return text::DisplayText(text::IsUtf8(bytes) ? std::string(bytes) : FromLatin1(bytes), "?");
}

namespace {

// Limits memory: a file can request many copies of a long name, as BVH does for end sites.
constexpr std::size_t kMaxName = 255;  // bytes

}  // namespace

std::string UniqueNames::Add(std::string_view name) {
  const std::string requested = std::string(text::TruncateUtf8(ToUtf8(name), kMaxName));
  std::string given = requested;
  // Numbering continues from the last number of the same name: not quadratic if all names are
  // equal.
  while (!taken_.emplace(given, 1).second) {
    given = fmt::format("{}_{}", requested, ++taken_[requested]);
  }
  if (given != requested) changed_.push_back(given);
  return given;
}

std::string UniqueNames::Note() const {
  constexpr std::size_t kShown = 3;
  if (changed_.empty()) return "";
  std::string note = "names used twice were made distinct: ";
  for (std::size_t i = 0; i < changed_.size() && i < kShown; ++i) {
    note += (i == 0 ? "" : ", ") + changed_[i];
  }
  return changed_.size() > kShown ? fmt::format("{} and {} more", note, changed_.size() - kShown)
                                  : note;
}

}  // namespace motiondb::core
