// Values in filters: patterns of text, numbers, durations, times and enumerations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/filter/syntax.h"
#include "storage/records.h"

namespace motiondb::server {

// A text in which each wildcard stands for any text.
class TextPattern {
 public:
  TextPattern() = default;
  // Matches whole texts exactly, or (`is_contained`) texts that contain the pattern, without
  // distinction between upper and lower case of A to Z.
  TextPattern(const FilterText& text, bool is_contained);

  // O(size of the text + size of the pattern).
  bool Matches(std::string_view text) const;

 private:
  std::vector<std::string> parts_ = {""};  // between wildcards
  std::size_t least_size_ = 0;             // of a text that matches
  bool ignores_case_ = false;
};

// Microseconds since the Unix epoch, without the end. A time is one microsecond, a date one day.
struct TimeRange {
  std::int64_t begin_us = 0;
  std::int64_t end_us = 0;
};

// Parse all of a text: a finite number; seconds as `2.5s` or `2.5`; an RFC 3339 time with a zone,
// years 1 to 9999, or a date in UTC; true or false.
std::optional<double> ParseFilterNumber(std::string_view text);
std::optional<double> ParseFilterDuration(std::string_view text);
std::optional<TimeRange> ParseFilterTime(std::string_view text);
std::optional<bool> ParseFilterFlag(std::string_view text);

// Returns a time as RFC 3339 in UTC, with as many digits of the second as it needs.
std::string TimeText(std::int64_t time_us);

// The names of sources of segments: person, import, suggestion.
std::string_view SegmentSourceText(storage::SegmentSource source);

}  // namespace motiondb::server
