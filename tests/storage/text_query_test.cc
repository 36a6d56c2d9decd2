// Words and queries of the full-text search.
#include "storage/text_query.h"

#include <catch2/catch.hpp>
#include <random>

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
  CHECK(NormalizeText("歩く・走る 걷기") == "歩く・走る 걷기");
  CHECK(NormalizeText("a–b “c” d…e f×g") == "a b c d e f g");
  CHECK(NormalizeText("dance 💃 step") == "dance 💃 step");  // not in the Basic Multilingual Plane
  CHECK(NormalizeText(std::string("a\0b", 3)) == "a b");
  CHECK(NormalizeText("x\xff\xfey \xc3") == "x y");  // not UTF-8
  CHECK(NormalizeText(storage::kItemSeparator).empty());
}

TEST_CASE("NormalizeText: normalising again changes nothing", "[storage][search]") {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    std::string text;
    for (int i = 0; i < 20; ++i) text += static_cast<char>(random());
    // Letters of the blocks that are folded.
    for (int i = 0; i < 10; ++i) {
      const unsigned c = 0xc0 + random() % 0x1f40;
      if (c < 0x800) {
        text += static_cast<char>(0xc0 | (c >> 6));
      } else {
        text += static_cast<char>(0xe0 | (c >> 12));
        text += static_cast<char>(0x80 | (c >> 6 & 0x3f));
      }
      text += static_cast<char>(0x80 | (c & 0x3f));
    }
    const std::string words = NormalizeText(text);
    REQUIRE(NormalizeText(words) == words);
    REQUIRE(words.find('"') == words.npos);
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
