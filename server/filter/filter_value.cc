#include "server/filter/filter_value.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>

namespace motiondb::server {
namespace {

constexpr std::int64_t kSecondUs = 1'000'000;
constexpr std::int64_t kDayUs = 86'400 * kSecondUs;

// Writes a text with lower-case letters a to z.
void CopyLowerCase(std::string_view text, char* lower) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool is_upper = static_cast<unsigned char>(c - 'A') < 26;
    lower[i] = static_cast<char>(is_upper ? c | 0x20 : c);
  }
}

// Returns the index of the first occurrence, in linear time.
std::size_t FindText(std::string_view text, std::string_view part) {
  if (part.empty()) return 0;
  const void* found = memmem(text.data(), text.size(), part.data(), part.size());
  if (found == nullptr) return std::string_view::npos;
  return static_cast<std::size_t>(static_cast<const char*>(found) - text.data());
}

// Whether a text has the parts in this order: the first at its beginning, the last at its end.
bool HasParts(std::string_view text, const std::vector<std::string>& parts) {
  if (parts.size() == 1) return text == parts[0];
  if (!text.starts_with(parts.front())) return false;
  text.remove_prefix(parts.front().size());
  if (!text.ends_with(parts.back())) return false;
  text.remove_suffix(parts.back().size());
  for (std::size_t i = 1; i + 1 < parts.size(); ++i) {
    const std::size_t found = FindText(text, parts[i]);
    if (found == std::string_view::npos) return false;
    text.remove_prefix(found + parts[i].size());
  }
  return true;
}

// Reads decimal digits and separators of a time.
class TimeReader {
 public:
  explicit TimeReader(std::string_view text) : rest_(text) {}

  bool is_ok() const { return is_ok_; }
  bool at_end() const { return rest_.empty(); }
  // Reads a number of `digits` digits in [least, most].
  int Number(std::size_t digits, int least, int most) {
    int value = 0;
    is_ok_ = is_ok_ && rest_.size() >= digits;
    for (std::size_t i = 0; is_ok_ && i < digits; ++i) value = value * 10 + Digit();
    is_ok_ = is_ok_ && value >= least && value <= most;
    return value;
  }
  // Passes one of the characters and returns it.
  char OneOf(std::string_view characters) {
    is_ok_ = is_ok_ && !rest_.empty() && characters.find(rest_[0]) != std::string_view::npos;
    if (!is_ok_) return '\0';
    const char c = rest_[0];
    rest_.remove_prefix(1);
    return c;
  }
  // Reads the fraction of a second, if there is one, in microseconds.
  std::int64_t Fraction() {
    if (rest_.empty() || rest_[0] != '.') return 0;
    rest_.remove_prefix(1);
    std::int64_t value = Digit() * (kSecondUs / 10);
    for (std::int64_t unit = kSecondUs / 100; is_ok_ && NextIsDigit(); unit /= 10) {
      value += Digit() * unit;
    }
    return value;
  }

 private:
  bool NextIsDigit() const { return !rest_.empty() && rest_[0] >= '0' && rest_[0] <= '9'; }
  int Digit() {
    is_ok_ = is_ok_ && NextIsDigit();
    if (!is_ok_) return 0;
    const int digit = rest_[0] - '0';
    rest_.remove_prefix(1);
    return digit;
  }

  std::string_view rest_;
  bool is_ok_ = true;
};

}  // namespace

TextPattern::TextPattern(const FilterText& text, bool is_contained)
    : parts_({}), ignores_case_(is_contained) {
  if (is_contained) parts_.emplace_back();
  std::size_t begin = 0;
  for (const std::size_t wildcard : text.wildcards) {
    parts_.push_back(text.text.substr(begin, wildcard - begin));
    begin = wildcard + 1;
  }
  parts_.push_back(text.text.substr(begin));
  if (is_contained) parts_.emplace_back();
  if (ignores_case_) {
    for (std::string& part : parts_) CopyLowerCase(part, part.data());
  }
  for (const std::string& part : parts_) least_size_ += part.size();
}

bool TextPattern::Matches(std::string_view text) const {
  if (text.size() < least_size_) return false;
  if (!ignores_case_) return HasParts(text, parts_);
  char buffer[512];
  if (text.size() <= sizeof(buffer)) {
    CopyLowerCase(text, buffer);
    return HasParts({buffer, text.size()}, parts_);
  }
  std::string lower(text.size(), '\0');
  CopyLowerCase(text, lower.data());
  return HasParts(lower, parts_);
}

std::optional<double> ParseFilterNumber(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || read != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> ParseFilterDuration(std::string_view text) {
  if (text.ends_with('s')) text.remove_suffix(1);
  return ParseFilterNumber(text);
}

std::optional<TimeRange> ParseFilterTime(std::string_view text) {
  using std::chrono::day, std::chrono::month, std::chrono::year;
  TimeReader reader(text);
  const int y = reader.Number(4, 1, 9999);
  reader.OneOf("-");
  const int m = reader.Number(2, 1, 12);
  reader.OneOf("-");
  const int d = reader.Number(2, 1, 31);
  const std::chrono::year_month_day date(year(y), month(static_cast<unsigned>(m)),
                                         day(static_cast<unsigned>(d)));
  if (!reader.is_ok() || !date.ok()) return std::nullopt;
  const std::int64_t midnight = std::chrono::sys_days(date).time_since_epoch().count() * kDayUs;
  if (reader.at_end()) return TimeRange{midnight, midnight + kDayUs};
  reader.OneOf("Tt");
  const int hour = reader.Number(2, 0, 23);
  reader.OneOf(":");
  const int minute = reader.Number(2, 0, 59);
  reader.OneOf(":");
  const int second = reader.Number(2, 0, 59);
  const std::int64_t fraction = reader.Fraction();
  const char zone = reader.OneOf("Zz+-");
  int offset_minutes = 0;
  if (zone == '+' || zone == '-') {
    offset_minutes = reader.Number(2, 0, 23) * 60;
    reader.OneOf(":");
    offset_minutes += reader.Number(2, 0, 59);
  }
  if (!reader.is_ok() || !reader.at_end()) return std::nullopt;
  if (zone == '-') offset_minutes = -offset_minutes;
  const std::int64_t seconds = (hour * 60 + minute - offset_minutes) * 60 + second;
  const std::int64_t time = midnight + seconds * kSecondUs + fraction;
  return TimeRange{time, time + 1};
}

std::optional<bool> ParseFilterFlag(std::string_view text) {
  if (text == "true") return true;
  if (text == "false") return false;
  return std::nullopt;
}

std::string TimeText(std::int64_t time_us) {
  using std::chrono::floor;
  const std::chrono::sys_time<std::chrono::microseconds> time{std::chrono::microseconds(time_us)};
  const auto day = floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::int64_t of_day = (time - day).count();
  const std::int64_t seconds = of_day / kSecondUs;
  std::string fraction;
  if (of_day % kSecondUs != 0) {
    fraction = fmt::format(".{:06}", of_day % kSecondUs);
    fraction.erase(fraction.find_last_not_of('0') + 1);
  }
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}{}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     seconds / 3600, seconds / 60 % 60, seconds % 60, fraction);
}

std::string_view SegmentSourceText(storage::SegmentSource source) {
  constexpr std::array<std::string_view, 3> kTexts = {"person", "import", "suggestion"};
  return kTexts[static_cast<std::size_t>(source) - 1];
}

}  // namespace motiondb::server
