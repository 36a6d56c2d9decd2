#include "client/cli/label_pattern.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::label_pattern_test {
namespace {

using client::LabelPattern;

// Returns "LABEL|SUBJECT", or an empty string if the path does not match.
std::string Read(const std::string& pattern, const std::string& path) {
  const auto labels = LabelPattern::Parse(pattern).value().Match(path);
  return labels ? labels->label + "|" + labels->subject : "";
}

std::string ErrorOf(const std::string& pattern) {
  return std::string(LabelPattern::Parse(pattern).status().message());
}

TEST_CASE("LabelPattern: matches the end of the path, in whole components", "[client][cli]") {
  CHECK(Read("{label}/*", "data/walk/07_01.amc") == "walk|");
  CHECK(Read("{label}/*", "/walk/07_01.amc") == "walk|");
  CHECK(Read("{label}/*/*", "data/walk/07/01.amc") == "walk|");
  CHECK(Read("{label}/*", "07_01.amc") == "");
  CHECK(Read("walk/{label}", "sidewalk/a.bvh") == "");
  CHECK(Read("{subject}/{label}/*.bvh", "data/bk/walk/1.bvh") == "walk|bk");
  CHECK(Read("{subject}/{label}/*.bvh", "data/bk/walk/1.c3d") == "");
}

TEST_CASE("LabelPattern: ignores the extension unless the pattern has one", "[client][cli]") {
  CHECK(Read("{label}", "a/walk.bvh") == "walk|");
  CHECK(Read("{label}_*", "walk_01.v2.bvh") == "walk|");
  CHECK(Read("*_{label}", "01_walk.v2.bvh") == "walk.v2|");
  CHECK(Read("{label}.bvh", "walk.bvh") == "walk|");
  CHECK(Read("{label}.bvh", "walk.c3d") == "");
}

TEST_CASE("LabelPattern: each part matches as little as possible", "[client][cli]") {
  CHECK(Read("{subject}_{label}_*", "bk_walk_fast_01.bvh") == "walk|bk");
  CHECK(Read("*_{subject}_{label}_*", "HDM_bk_walk_01.amc") == "walk|bk");
  CHECK(Read("{label}_{subject}", "walk_fast_bk.bvh") == "walk|fast_bk");
  CHECK(Read("{label}*", "walk.bvh") == "w|");
  CHECK(Read("{label}*k", "walk.bvh") == "w|");
  CHECK(Read("*{label}", "walk.bvh") == "walk|");
}

TEST_CASE("LabelPattern: a placeholder matches at least one character, * also none",
          "[client][cli]") {
  CHECK(Read("{subject}_{label}", "_walk.bvh") == "");
  CHECK(Read("{subject}_{label}", "bk_.bvh") == "");
  CHECK(Read("{subject}_{label}", "__a.bvh") == "a|_");
  CHECK(Read("*_{label}", "_walk.bvh") == "walk|");
  CHECK(Read("{label}_*", "walk_.bvh") == "walk|");
}

TEST_CASE("LabelPattern: paths are normalized, and .. is no label", "[client][cli]") {
  CHECK(Read("{label}/*", "lists/../walk/./a.bvh") == "walk|");
  CHECK(Read("{label}/*", "./a.bvh") == "");
  CHECK(Read("{label}/*", "../a.bvh") == "");
  CHECK(Read("{label}/*", "../walk/a.bvh") == "walk|");
}

TEST_CASE("LabelPattern: characters of regular expressions match themselves", "[client][cli]") {
  CHECK(Read("({label}+$)", "(walk+$).bvh") == "walk|");
  CHECK(Read("[a]?{label}", "[a]?walk.bvh") == "walk|");
  CHECK(Read("[a]?{label}", "awalk.bvh") == "");
  CHECK(Read("{label}}", "walk}.bvh") == "walk|");
}

TEST_CASE("LabelPattern: long names with many * take little time", "[client][cli]") {
  std::string pattern = "{label}";
  for (int i = 0; i < 60; ++i) pattern += "*a";
  CHECK(Read(pattern + "b", std::string(250, 'a')) == "");
  CHECK(Read(pattern, std::string(250, 'a')) == "a|");
}

TEST_CASE("LabelPattern: errors name what was expected", "[client][cli]") {
  CHECK(ErrorOf("{subject}/*") == "expected {label} in the pattern");
  CHECK(ErrorOf("{label}/{label}") == "expected {label} and {subject} at most once");
  CHECK(ErrorOf("{label}_{subject}_{subject}") == "expected {label} and {subject} at most once");
  CHECK(ErrorOf("{name}/*") == "expected {label} or {subject}, got {name}");
  CHECK(ErrorOf("{label") == "expected {label} or {subject}, got {label");
  CHECK(ErrorOf("{label}/**/*") == "expected * instead of **");
  for (const char* pattern : {"", "/{label}", "{label}/", "{label}//*"}) {
    CHECK(ErrorOf(pattern) == "expected a name before, between and after slashes");
  }
}

}  // namespace
}  // namespace motiondb::tests::label_pattern_test
