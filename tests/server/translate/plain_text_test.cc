#include <catch2/catch.hpp>
#include <string>

#include "server/engine/ingest_rules.h"
#include "server/engine/request_checks.h"
#include "server/translate/resource_name.h"
#include "tests/support/shown_text_cases.h"

namespace motiondb::tests::plain_text_test {
namespace {

std::string Utf8(char32_t c) {
  if (c < 0x80) return {static_cast<char>(c)};
  if (c < 0x800) return {static_cast<char>(0xC0 | (c >> 6)), static_cast<char>(0x80 | (c & 0x3F))};
  return {static_cast<char>(0xE0 | (c >> 12)), static_cast<char>(0x80 | ((c >> 6) & 0x3F)),
          static_cast<char>(0x80 | (c & 0x3F))};
}

TEST_CASE("PlainText: a display control is refused and named", "[server][translate]") {
  for (const auto& [first, last] : kDisplayControls) {
    for (char32_t c = first; c <= last; ++c) {
      CAPTURE(static_cast<unsigned>(c));
      CHECK(absl::IsInvalidArgument(server::CheckPlainText("label", "a" + Utf8(c) + "b", 255)));
      const bool in_files = c == '\n' || c == '\r' || c == '\t';
      CHECK(server::CheckPlainLines("file", "a" + Utf8(c) + "b").ok() == in_files);
    }
  }
  CHECK(server::CheckPlainText("label", "\xC2\x9B", 255).message() ==
        "label: expected text, got the control or invisible format character U+009B; omit it");
  CHECK(server::CheckPlainText("label", "M\xC3\xBCller \xF0\x9F\x8F\x83 \xD7\x90", 255).ok());
  CHECK(absl::IsInvalidArgument(server::CheckPlainText("label", "abc", 2)));
  CHECK(server::CheckPlainLines("file", "name a\r\nmarker\tb\n").ok());
}

TEST_CASE("PlainText: a token is refused in every stored text", "[server][translate]") {
  for (const absl::Status& status :
       {server::CheckPlainText("label", AnyToken(), 255),
        server::CheckPlainText("label", "for " + AnyToken().substr(0, 40), 255),
        server::CheckPlainLines("file", "name " + AnyToken() + "\n"),
        server::CheckDatabaseId("id", AnyToken().substr(0, 60)),
        server::CheckClipId("id", AnyToken())}) {
    CHECK(absl::IsInvalidArgument(status));
    CHECK_THAT(std::string(status.message()), Catch::Contains("token"));
  }
}

}  // namespace
}  // namespace motiondb::tests::plain_text_test
