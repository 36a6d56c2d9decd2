#include "server/translate/page.h"

#include <catch2/catch.hpp>

namespace motiondb::server::page_test {
namespace {

TEST_CASE("Page: sizes have a default and a maximum", "[server][translate]") {
  CHECK(*PageSize(0, 100, 1000) == 100);
  CHECK(*PageSize(7, 100, 1000) == 7);
  CHECK(*PageSize(5000, 100, 1000) == 1000);
  CHECK(absl::IsInvalidArgument(PageSize(-1, 100, 1000).status()));
}

TEST_CASE("Page: a token is valid only for its list", "[server][translate]") {
  const std::string token = EncodePageToken("databases/a/clips", "walk");
  CHECK(*DecodePageToken("databases/a/clips", token) == "walk");
  CHECK(*DecodePageToken("databases/a/clips", "") == "");
  CHECK(absl::IsInvalidArgument(DecodePageToken("databases/b/clips", token).status()));
  CHECK(!DecodePageToken("databases/a/clips", "!!").ok());
  CHECK(!DecodePageToken("databases/a/clips", token.substr(0, 8)).ok());
  CHECK(!DecodePageToken("databases/a/clips", EncodePageToken("databases/a/clips", "")).ok());
}

TEST_CASE("Page: is limited by items and bytes, but has at least one item", "[server][translate]") {
  PageBudget few(2);
  CHECK(few.Take(1));
  CHECK(few.Take(1));
  CHECK(!few.Take(1));
  PageBudget large(100);
  CHECK(large.Take(10 << 20));
  CHECK(!large.Take(1));
}

TEST_CASE("Page: a position in a model is bound to its version and time", "[server][translate]") {
  const std::string token = EncodeModelPosition("nodes", {{3, 1234567890123456}, 40});
  const auto position = DecodeModelPosition("nodes", token);
  REQUIRE(position.ok());
  CHECK(position->model.version == 3);
  CHECK(position->model.create_time_us == 1234567890123456);
  CHECK(position->index == 40);
  CHECK(DecodeModelPosition("nodes", "")->model.create_time_us == 0);
  for (const char* forged : {"x", "3", "3:", "3:5", "3:5:", "3:5:-1", "3:5:4:5", ":5:4", "3::4"}) {
    CHECK(!DecodeModelPosition("nodes", EncodePageToken("nodes", forged)).ok());
  }
}

}  // namespace
}  // namespace motiondb::server::page_test
