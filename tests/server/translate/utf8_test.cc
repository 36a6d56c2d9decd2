#include "server/translate/utf8.h"

#include <catch2/catch.hpp>

namespace motiondb::server {
namespace {

TEST_CASE("Utf8: valid text stays as it is", "[server][translate]") {
  for (const std::string text :
       {"", "walk", "Schr\xc3\xa4g", "\xe6\xad\xa9\xe3\x81\x8f", "\xf0\x9f\x9a\xb6"}) {
    CHECK(ValidUtf8(text) == text);
  }
}

TEST_CASE("Utf8: what is not valid is replaced, byte by byte", "[server][translate]") {
  const std::string mark = "\xef\xbf\xbd";
  CHECK(ValidUtf8("a\xff"
                  "b") == "a" + mark + "b");
  CHECK(ValidUtf8("\xc3") == mark);                        // cut short
  CHECK(ValidUtf8("\xc0\xaf") == mark + mark);             // overlong
  CHECK(ValidUtf8("\xed\xa0\x80") == mark + mark + mark);  // surrogate
  CHECK(ValidUtf8("\xf4\x90\x80\x80").size() == 4 * 3);    // beyond U+10FFFF
  CHECK(ValidUtf8("Schr\xe4g") == "Schr" + mark + "g");    // Latin-1
}

TEST_CASE("Utf8: a limit cuts between characters", "[server][translate]") {
  CHECK(ValidUtf8("abcdef", 6) == "abcdef");
  CHECK(ValidUtf8("abcdefg", 6) == "abc...");
  CHECK(ValidUtf8("ab\xc3\xa4\xc3\xa4\xc3\xa4", 6) == "ab...");
}

}  // namespace
}  // namespace motiondb::server
