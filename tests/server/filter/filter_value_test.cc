// Values of filters: numbers, durations, times, and patterns of text.
#include "server/filter/filter_value.h"

#include <catch2/catch.hpp>
#include <string>

namespace motiondb::tests {
namespace filter_value {
namespace {

using server::FilterText;
using server::ParseFilterDuration;
using server::ParseFilterNumber;
using server::ParseFilterTime;
using server::TextPattern;
using server::TimeText;

TEST_CASE("Numbers and durations") {
  CHECK(ParseFilterNumber("2.5") == 2.5);
  CHECK(ParseFilterNumber("-1e3") == -1000);
  for (const char* text : {"", " 1", "1 ", "1,5", "0x10", "inf", "nan", "1e999", "2.5s"}) {
    CAPTURE(text);
    CHECK(!ParseFilterNumber(text).has_value());
  }
  CHECK(ParseFilterDuration("2.5s") == 2.5);
  CHECK(ParseFilterDuration("2.5") == 2.5);
  CHECK(!ParseFilterDuration("2.5ss").has_value());
  CHECK(!ParseFilterDuration("s").has_value());
}

TEST_CASE("Times and dates") {
  constexpr std::int64_t kDay = 86'400'000'000;
  struct Example {
    const char* text;
    std::int64_t begin_us;
    std::int64_t size_us;
  };
  // As `date -u -d TEXT +%s` says.
  const Example kExamples[] = {{"1970-01-01", 0, kDay},
                               {"2000-02-29", 951'782'400'000'000, kDay},
                               {"1969-12-31T23:59:59Z", -1'000'000, 1},
                               {"2026-05-01T12:00:00Z", 1'777'636'800'000'000, 1},
                               {"2026-05-01t12:00:00z", 1'777'636'800'000'000, 1},
                               {"2026-05-01T14:30:00+02:30", 1'777'636'800'000'000, 1},
                               {"2026-05-01T07:00:00.25-05:00", 1'777'636'800'250'000, 1},
                               {"2026-05-01T12:00:00.1234567Z", 1'777'636'800'123'456, 1}};
  for (const Example& example : kExamples) {
    CAPTURE(example.text);
    const auto range = ParseFilterTime(example.text);
    REQUIRE(range.has_value());
    CHECK(range->begin_us == example.begin_us);
    CHECK(range->end_us == example.begin_us + example.size_us);
  }
  for (const char* text :
       {"", "2026", "2026-5-1", "2026-13-01", "2026-00-01", "2025-02-29", "0000-01-01",
        "2026-05-01T12:00:00", "2026-05-01 12:00:00Z", "2026-05-01T24:00:00Z",
        "2026-05-01T12:60:00Z", "2026-05-01T12:00:60Z", "2026-05-01T12:00:00.Z",
        "2026-05-01T12:00:00+2", "2026-05-01T12:00:00Zx", "2026-05-01T12:00Z", "2026-05-01x"}) {
    CAPTURE(text);
    CHECK(!ParseFilterTime(text).has_value());
  }
}

TEST_CASE("A printed time is read as the same time") {
  for (const std::int64_t time :
       {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1'777'636'800'120'000},
        std::int64_t{-62'135'596'800'000'000}}) {
    CAPTURE(time, TimeText(time));
    const auto range = ParseFilterTime(TimeText(time));
    REQUIRE(range.has_value());
    CHECK(range->begin_us == time);
  }
  CHECK(TimeText(1'777'636'800'120'000) == "2026-05-01T12:00:00.12Z");
}

TEST_CASE("A pattern takes time in proportion to the text", "[hostile]") {
  const std::string as(1 << 20, 'a');
  FilterText text{.text = as.substr(0, 2000) + "b*" + as.substr(0, 1000) + "b"};
  text.wildcards = {2001};
  CHECK(!TextPattern(text, true).Matches(as));
  CHECK(TextPattern(text, true).Matches(as + "B" + as + "b"));
}

}  // namespace
}  // namespace filter_value
}  // namespace motiondb::tests
