#include "text/utf8.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::utf8_test {
namespace {

TEST_CASE("ValidUtf8: valid text does not change", "[text]") {
  for (const std::string text :
       {"", "walk", "Schr\xc3\xa4g", "\xe6\xad\xa9\xe3\x81\x8f", "\xf0\x9f\x9a\xb6"}) {
    CHECK(text::ValidUtf8(text) == text);
  }
}

TEST_CASE("ValidUtf8: each invalid byte is replaced", "[text]") {
  const std::string mark = "\xef\xbf\xbd";
  CHECK(text::ValidUtf8("a\xff"
                        "b") == "a" + mark + "b");
  CHECK(text::ValidUtf8("\xc3") == mark);                        // incomplete
  CHECK(text::ValidUtf8("\xc0\xaf") == mark + mark);             // overlong
  CHECK(text::ValidUtf8("\xed\xa0\x80") == mark + mark + mark);  // surrogate
  CHECK(text::ValidUtf8("\xf4\x90\x80\x80").size() == 4 * 3);    // beyond U+10FFFF
  CHECK(text::ValidUtf8("Schr\xe4g") == "Schr" + mark + "g");    // Latin-1
}

TEST_CASE("IsUtf8: accepts well-formed text only", "[text]") {
  for (const char* good : {"", "walk", "M\xC3\xBCller", "\xE2\x82\xAC", "\xF0\x9F\x8F\x83"}) {
    CHECK(text::IsUtf8(good));
  }
  for (const char* bad : {"M\xFCller", "\xC3", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80",
                          "\xF4\x90\x80\x80", "\xE2\x82", "\x80", "\xC3\xC3"}) {
    CHECK(!text::IsUtf8(bad));
  }
}

TEST_CASE("AppendUtf8: writes every character as FirstCharacter reads it", "[text]") {
  for (char32_t code = 0; code <= 0x10FFFF; ++code) {
    if (code == 0xD800) code = 0xE000;  // surrogates are no characters
    std::string written = "a";
    text::AppendUtf8(code, written);
    const text::Character read = text::FirstCharacter(std::string_view(written).substr(1));
    if (read.code != code || read.bytes + 1 != written.size()) FAIL("U+" << std::hex << +code);
  }
}

TEST_CASE("LowerCase: changes the letters A to Z only", "[text]") {
  CHECK(text::LowerCase("Left_FOOT[Z]@\xC3\x84") == "left_foot[z]@\xC3\x84");
  CHECK(text::LowerCase("").empty());
}

TEST_CASE("TruncateUtf8: cuts between characters", "[text]") {
  const std::string_view mixed = "\xC3\xA4\xE2\x82\xAC\xF0\x9F\x8F\x83z";
  const std::size_t ends[] = {0, 0, 2, 2, 2, 5, 5, 5, 5, 9, 10, 10};
  for (std::size_t bytes = 0; bytes < std::size(ends); ++bytes) {
    CHECK(text::TruncateUtf8(mixed, bytes) == mixed.substr(0, ends[bytes]));
  }
}

TEST_CASE("ValidUtf8: a limit cuts between characters", "[text]") {
  CHECK(text::ValidUtf8("abcdef", 6) == "abcdef");
  CHECK(text::ValidUtf8("abcdefg", 6) == "abc...");
  CHECK(text::ValidUtf8("ab\xc3\xa4\xc3\xa4\xc3\xa4", 6) == "ab...");
}

}  // namespace
}  // namespace motiondb::tests::utf8_test
