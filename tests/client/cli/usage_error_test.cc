#include "client/cli/usage/usage_error.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

namespace motiondb::tests::usage_error_test {
namespace {

using client::DidYouMean;
using client::EditDistance;

// The definition, without the table: exponential in the lengths.
std::size_t SlowDistance(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  const std::string_view a1 = a.substr(1), b1 = b.substr(1);
  std::size_t best = std::min({SlowDistance(a1, b) + 1, SlowDistance(a, b1) + 1,
                               SlowDistance(a1, b1) + (a[0] == b[0] ? 0 : 1)});
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0]) {
    best = std::min(best, SlowDistance(a.substr(2), b.substr(2)) + 1);
  }
  return best;
}

TEST_CASE("EditDistance: equals its definition", "[client][cli]") {
  std::mt19937 random(3);
  const auto word = [&] {
    std::string text(std::uniform_int_distribution<std::size_t>(0, 6)(random), 'a');
    for (char& c : text) c = static_cast<char>('a' + random() % 3);
    return text;
  };
  for (int i = 0; i < 300; ++i) {
    const std::string a = word(), b = word();
    CAPTURE(a, b);
    CHECK(EditDistance(a, b) == SlowDistance(a, b));
    CHECK(EditDistance(a, b) == EditDistance(b, a));
  }
}

TEST_CASE("DidYouMean: the nearest word, if one is near", "[client][cli]") {
  const std::vector<std::string> words = {"recognize", "restore", "reprocess", "list"};
  CHECK(DidYouMean("recognise", words) == "; did you mean 'recognize'?");
  CHECK(DidYouMean("lsit", words) == "; did you mean 'list'?");
  CHECK(DidYouMean("LIST", words) == "; did you mean 'list'?");
  CHECK(DidYouMean("plan", words).empty());
  CHECK(DidYouMean("", words).empty());
  CHECK(DidYouMean("x", {"y"}).empty());  // no character is equal
  CHECK(DidYouMean("x", {}).empty());
  CHECK(DidYouMean(std::string(100'000, 'x'), words).empty());
}

}  // namespace
}  // namespace motiondb::tests::usage_error_test
