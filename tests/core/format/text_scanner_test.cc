#include "core/format/text_scanner.h"

#include <catch2/catch.hpp>
#include <charconv>
#include <random>
#include <sstream>
#include <string>

namespace motiondb::tests::text_scanner_test {

using core::IsKeyword;
using core::ParseNumber;
using core::TextScanner;
using core::ToUtf8;

TEST_CASE("CountWords: equals the words of a stream", "[core][format]") {
  std::mt19937 random(5);
  const std::string letters = "ab7.-# \t\n\r\v\f\x1f\x80\xff";
  for (int round = 0; round < 300; ++round) {
    std::string text(random() % 1200, ' ');
    // Long words, long gaps, or both.
    const std::size_t first = round % 3 == 0 ? 6 : 0;
    const std::size_t count = round % 3 == 1 ? 7 : letters.size() - first;
    for (char& c : text) c = letters[first + random() % count];
    std::istringstream stream(text);
    std::size_t words = 0;
    for (std::string word; stream >> word;) ++words;
    CAPTURE(text);
    REQUIRE(core::CountWords(text) == words);
  }
  CHECK(core::CountWords("a " + std::string(1000, ' ') + "b") == 2);
}

TEST_CASE("ParseNumber: every form in motion files", "[core][format]") {
  CHECK(ParseNumber("0") == 0.0);
  CHECK(ParseNumber("-0.5") == -0.5);
  CHECK(ParseNumber("1e-5") == 1e-5);
  CHECK(ParseNumber("+3") == 3.0);
  CHECK(ParseNumber("1.5E+02") == 150.0);
  CHECK(ParseNumber(".0083") == 0.0083);
  CHECK(ParseNumber("-.5") == -0.5);
  CHECK(ParseNumber("5.") == 5.0);
  CHECK(ParseNumber("7.62852e-016") == 7.62852e-16);
  CHECK(ParseNumber("1e-4000") == 0.0);
  CHECK(ParseNumber("0.016666666666666666") == 0.016666666666666666);
}

TEST_CASE("ParseNumber: anything else is no number", "[core][format]") {
  for (const char* text :
       {"",     "-",   "+",   ".",   "e5",   "1.2abc", "1e", "nan", "-nan",   "inf",
        "-Inf", "+-3", "-+3", "--3", "0x10", "1,5",    "1 ", " 1",  "1e4000", "1e19"}) {
    CAPTURE(text);
    CHECK_FALSE(ParseNumber(text).has_value());
  }
  CHECK_FALSE(ParseNumber(std::string_view()).has_value());
}

TEST_CASE("ParseNumber: the fast path rounds like std::from_chars", "[core][format]") {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> digit(0, 9);
  std::uniform_int_distribution<int> length(0, 17);
  for (int i = 0; i < 20000; ++i) {
    std::string text = i % 2 == 0 ? "-" : "";
    for (int n = length(random); n > 0; --n) text += static_cast<char>('0' + digit(random));
    text += '.';
    for (int n = length(random); n >= 0; --n) text += static_cast<char>('0' + digit(random));
    double expected = 0;
    std::from_chars(text.data(), text.data() + text.size(), expected);
    CAPTURE(text);
    REQUIRE(ParseNumber(text) == expected);
  }
}

TEST_CASE("IsKeyword: letter case does not matter, length does", "[core][format]") {
  CHECK(IsKeyword("OfFsEt", "offset"));
  CHECK_FALSE(IsKeyword("offsets", "offset"));
  CHECK_FALSE(IsKeyword("", "offset"));
}

TEST_CASE("TextScanner: tokens, punctuation and the byte order mark", "[core][format]") {
  TextScanner scanner({.name = "f", .bytes = "\xEF\xBB\xBF a{b\tc}\r\n\vd"}, "{}");
  for (const char* expected : {"a", "{", "b", "c", "}", "d", ""})
    CHECK(scanner.Token() == expected);
}

TEST_CASE("TextScanner: LF, CRLF and lone CR all end lines", "[core][format]") {
  for (const char* text : {"one  two \n\nthree", "one  two \r\n\r\nthree", "one  two \r\rthree",
                           "one  two \r\n\rthree", "one  two \n\rthree"}) {
    TextScanner scanner({.name = "f", .bytes = text});
    CHECK(scanner.TokenOnLine() == "one");
    CHECK(scanner.RestOfLine() == "two");
    CHECK(scanner.TokenOnLine().empty());
    CHECK(scanner.RestOfLine().empty());
    CHECK(scanner.TokenOnLine() == "three");
    const absl::Status status = scanner.Expected("four", scanner.LastRead());
    CHECK(std::string(status.message()) == "f:3: expected four, found 'three'");
    CHECK(scanner.AtEnd());
  }
}

TEST_CASE("TextScanner: errors distinguish the end of a line from the end of the file",
          "[core][format]") {
  TextScanner scanner({.name = "f", .bytes = "1\n2"});
  double value = 0;
  REQUIRE(scanner.TryNumberOnLine(value));
  CHECK_FALSE(scanner.TryNumberOnLine(value));
  CHECK(std::string(scanner.Expected("x", "").message()) == "f:1: the line ends here, expected x");
  REQUIRE(scanner.TryNumber(value));
  CHECK(value == 2);
  CHECK(std::string(scanner.ReadNumber("x", value).message()) ==
        "f:2: the file ends here (truncated?), expected x");
  CHECK(scanner.EndsInToken());
}

TEST_CASE("TextScanner: integers must be whole and in range", "[core][format]") {
  int value = 0;
  CHECK(TextScanner({.name = "f", .bytes = "12"}).ReadInteger("n", 0, 12, value).ok());
  CHECK(value == 12);
  for (const char* text : {"13", "-1", "1.5", "abc", ""}) {
    CHECK_FALSE(TextScanner({.name = "f", .bytes = text}).ReadInteger("n", 0, 12, value).ok());
  }
}

TEST_CASE("ToUtf8: valid text is kept, other bytes are read as Latin-1", "[core][format]") {
  CHECK(ToUtf8("Hips") == "Hips");
  CHECK(ToUtf8("H\xC3\xBC"
               "fte") ==
        "H\xC3\xBC"
        "fte");
  CHECK(ToUtf8("H\xFC"
               "fte") ==
        "H\xC3\xBC"
        "fte");
  CHECK(ToUtf8("a\x01\x7F") == "a??");
  CHECK(ToUtf8("a\xC2\x9B\xE2\x80\xAE\xE2\x80\xA8") == "a???");
  CHECK(ToUtf8("\xE2\x82") == "\xC3\xA2?");              // truncated
  CHECK(ToUtf8("\xC0\xAF") == "\xC3\x80\xC2\xAF");       // overlong
  CHECK(ToUtf8("\xED\xA0\x80") == "\xC3\xAD\xC2\xA0?");  // surrogate
  CHECK(ToUtf8("\xF0\x9F\x98\x80") == "\xF0\x9F\x98\x80");
}

TEST_CASE("UniqueNames: a duplicate name is numbered and reported", "[core][format]") {
  core::UniqueNames names;
  CHECK(names.Add("Hand") == "Hand");
  CHECK(names.Note().empty());
  CHECK(names.Add("Hand_2") == "Hand_2");
  CHECK(names.Add("Hand") == "Hand_3");
  CHECK(names.Note() == "names used twice were made distinct: Hand_3");
}

}  // namespace motiondb::tests::text_scanner_test
