// Words and queries of the full-text search.
#include "storage/text_query.h"

#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "tests/storage/require_ok.h"

namespace motiondb::tests::text_query_test {
namespace {

using absl::StatusCode;
using storage::NormalizeText;
using storage::ParseTextQuery;
using storage::TextTerm;
using Terms = std::vector<TextTerm>;

}  // namespace

TEST_CASE("NormalizeText: words in lower case, without accents", "[storage][search]") {
  CHECK(NormalizeText("").empty());
  CHECK(NormalizeText(" -_./'\"()\t\n").empty());
  CHECK(NormalizeText("Walk_01 (slow).BVH") == "walk 01 slow bvh");
  CHECK(NormalizeText("CAFÉ café cafe\xcc\x81") == "cafe cafe cafe");
  CHECK(NormalizeText("Über Łódź Ångström") == "uber łodz angstrom");
  CHECK(NormalizeText("Việt Nguyễn") == "viet nguyen");
  CHECK(NormalizeText("ΒΗΜΑ Шаг ХОДЬБА") == "βημα шаг ходьба");
  CHECK(NormalizeText("歩く・走る 걷기") == "歩く 走る 걷기");
  CHECK(NormalizeText("a–b “c” d…e f×g") == "a b c d e f g");
  CHECK(NormalizeText("dance 💃 step ❤️") == "dance step");
  CHECK(NormalizeText("𐐀𐐨") == "𐐨𐐨");  // not in the Basic Multilingual Plane
  CHECK(NormalizeText(std::string("a\0b", 3)) == "a b");
  CHECK(NormalizeText("x\xff\xfey \xc3") == "x y");  // not UTF-8
  CHECK(NormalizeText(storage::kItemSeparator).empty());
}

TEST_CASE("NormalizeText: scripts and their accents", "[storage][search]") {
  const auto [text, words] = GENERATE(table<std::string, std::string>({
      {"Ἀθῆναι ΣΟΦΟΣ σοφός ᾼ", "αθηναι σοφοσ σοφοσ αι"},  // the final sigma is folded
      {"ЁЛКА йога Київ", "елка иога киів"},
      {"e\xcc\x81\xcc\xa3 ế Đ", "e e đ"},
      {"ệ e\xcc\x82\xcc\xa3 e\xcc\xa3\xcc\x82", "e e e"},  // any order of the accents
      {"ﬁnal ﬃx Straße STRASSE Ǆ", "final ffix strasse strasse ǆ"},
      {"İstanbul ısı", "istanbul ısı"},
      {"\xe1\x84\x92\xe1\x85\xa1\xe1\x86\xab 한", "한 한"},  // composed
      {"か\xe3\x82\x99 が", "が が"},                        // the mark is a part of the letter
      {"हिन्दी किताब", "हिन्दी किताब"},
      {"m² Ⅳ ٣ Vicon™ 50%", "m ⅳ ٣ vicon 50"},
      {"\xcc\x81 \xe3\x82\x99x", "x"},  // marks without a letter
  }));
  CHECK(NormalizeText(text) == words);
}

namespace {

std::string Utf8(unsigned c) {
  const auto byte = [](unsigned value) { return static_cast<char>(value); };
  const auto next = [&](int shift) { return byte(0x80 | (c >> shift & 0x3f)); };
  if (c < 0x80) return {byte(c)};
  if (c < 0x800) return {byte(0xc0 | c >> 6), next(0)};
  if (c < 0x10000) return {byte(0xe0 | c >> 12), next(6), next(0)};
  return {byte(0xf0 | c >> 18), next(12), next(6), next(0)};
}

}  // namespace

TEST_CASE("NormalizeText: normalising again changes nothing", "[storage][search]") {
  std::mt19937 random(1);
  const auto require = [](const std::string& text) {
    const std::string words = NormalizeText(text);
    if (NormalizeText(words) != words || words.find('"') != words.npos) FAIL(text);
  };
  for (unsigned c = 0; c <= 0x110000; ++c) {  // also surrogates and what is no character
    require(Utf8(c));
    require("a" + Utf8(c) + "\xcc\x81");
  }
  for (int round = 0; round < 20'000; ++round) {
    std::string text;
    for (unsigned i = random() % 8; i > 0; --i) text += static_cast<char>(random());
    for (unsigned i = random() % 12; i > 0; --i) {
      constexpr std::array kRanges = {0x80u, 0x600u, 0x2000u, 0x20000u};
      const bool is_mark = random() % 3 == 0;
      text += Utf8(is_mark ? 0x300 + random() % 0x70 : random() % kRanges[random() % 4]);
    }
    require(text);
    require(text.substr(text.size() / 2));
  }
}

TEST_CASE("NormalizeText: upper case, and accents of Latin letters, do not matter",
          "[storage][search]") {
  // In Unicode's order, these are alternately upper and lower case.
  for (unsigned c = 0x1e00; c < 0x1e96; c += 2)
    CHECK(NormalizeText(Utf8(c)) == NormalizeText(Utf8(c + 1)));
  for (unsigned c = 0x410; c < 0x430; ++c)
    CHECK(NormalizeText(Utf8(c)) == NormalizeText(Utf8(c + 0x20)));
  for (const std::string letter : {"a", "e", "o", "u", "z", "ø"}) {
    for (unsigned accent = 0x300; accent < 0x370; ++accent) {
      if (accent == 0x345) continue;  // a letter below another one: it becomes iota
      CHECK(NormalizeText(letter + Utf8(accent)) == letter);
    }
  }
}

TEST_CASE("ParseTextQuery: words, prefixes and phrases", "[storage][search]") {
  CHECK(Require(ParseTextQuery("walk")) == Terms{{{"walk"}}});
  CHECK(Require(ParseTextQuery("  Slow\tWALK* ")) == Terms{{{"slow"}}, {{"walk"}, true}});
  CHECK(Require(ParseTextQuery("\"Slow walk\" café")) == Terms{{{"slow", "walk"}}, {{"cafe"}}});
  CHECK(Require(ParseTextQuery("walk_01.b*")) == Terms{{{"walk", "01", "b"}, true}});
  CHECK(Require(ParseTextQuery("AND NOT or")) == Terms{{{"and"}}, {{"not"}}, {{"or"}}});
}

TEST_CASE("ParseTextQuery: errors have a position", "[storage][search]") {
  const auto [query, message] = GENERATE(table<std::string, std::string>({
      {"", "position 1: expected a word"},
      {"   ", "position 1: expected a word"},
      {"walk \"slow", "position 6: expected a second"},
      {"walk --", "position 6: expected a letter or a digit"},
      {"*", "position 1: expected a letter or a digit"},
      {"walk *", "position 6: expected a letter or a digit"},
      {"\"\"", "position 1: expected a word in the phrase"},
      {"wa*lk", "position 4: expected a space"},
      {"wa\"lk\"", "position 3: expected a space"},
      {"\"slow walk\"x", "position 12: expected a space"},
      {"\"slow walk\"*", "position 12: expected a space"},
  }));
  REQUIRE_ERROR(ParseTextQuery(query), StatusCode::kInvalidArgument, message);
}

TEST_CASE("Matches: all terms, each in one field", "[storage][search]") {
  storage::ClipRecord clip;
  clip.title = "Slow walk";
  clip.tags = {"night", "set-2"};
  clip.file_name = "walk_01.bvh";
  std::vector<storage::SegmentRecord> segments(3);
  segments[0].label = "turn left";
  segments[1].label = "walk";
  segments[2].label = "walk";
  const storage::ClipText text = storage::TextOf(clip, segments);
  CHECK(text[3] == "turn left " + std::string(storage::kItemSeparator) + " walk");
  const auto matches = [&](const std::string& query) {
    return storage::Matches(text, Require(ParseTextQuery(query)));
  };
  CHECK(matches("slow left 01"));
  CHECK(matches("\"slow walk\""));
  CHECK(matches("\"turn left\""));
  CHECK(matches("sl* le*"));
  CHECK_FALSE(matches("slow right"));
  CHECK_FALSE(matches("\"left walk\""));
  CHECK_FALSE(matches("\"walk slow\""));
  CHECK_FALSE(matches("wal"));
}

}  // namespace motiondb::tests::text_query_test
