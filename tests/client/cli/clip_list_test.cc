#include <catch2/catch.hpp>

#include "client/cli/clip_files.h"

namespace motiondb::tests::clip_list_test {
namespace {

using client::ParseClipList;

std::string ErrorOf(const std::string& text) {
  return std::string(ParseClipList("sets/a.tsv", text).status().message());
}

TEST_CASE("ClipList: columns in any order, with unknown columns", "[client][cli]") {
  const auto clips = ParseClipList(
      "sets/a.tsv", "label\tframes\tsubject\tpath\tskeleton\nwalk\t12\tbk\t../w.amc\t../bk.asf\n");
  REQUIRE(clips.ok());
  REQUIRE(clips->size() == 1);
  CHECK((*clips)[0].path == "sets/../w.amc");
  CHECK((*clips)[0].label == "walk");
  CHECK((*clips)[0].subject == "bk");
  CHECK((*clips)[0].skeleton == "sets/../bk.asf");
}

TEST_CASE("ClipList: accepts CRLF, blank lines, comments and a byte-order mark", "[client][cli]") {
  const auto clips = ParseClipList(
      "a.tsv", "\xEF\xBB\xBFpath\tlabel\r\n\r\n# held back\r\n/data/one.bvh\twalk\r\ntwo.bvh\t");
  REQUIRE(clips.ok());
  REQUIRE(clips->size() == 2);
  CHECK((*clips)[0].path == "/data/one.bvh");
  CHECK((*clips)[0].label == "walk");
  CHECK((*clips)[1].path == "two.bvh");
  CHECK((*clips)[1].label.empty());
  CHECK((*clips)[1].skeleton.empty());
}

TEST_CASE("ClipList: errors name file, line and what was expected", "[client][cli]") {
  CHECK_THAT(ErrorOf(""), Catch::StartsWith("sets/a.tsv:1: expected a header line"));
  CHECK_THAT(
      ErrorOf("\nfile\tlabel\n"),
      Catch::StartsWith("sets/a.tsv:2: expected a header line") && Catch::Contains("\"path\""));
  CHECK(ErrorOf("path\tlabel\nw.bvh\twalk\nx.bvh\n") ==
        "sets/a.tsv:3: expected 2 cells, separated by tabs, found 1");
  CHECK(ErrorOf("path\tlabel\n\twalk\n") == "sets/a.tsv:2: expected a path, found nothing");
}

}  // namespace
}  // namespace motiondb::tests::clip_list_test
