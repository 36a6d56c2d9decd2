#include "text/display_text.h"

#include <catch2/catch.hpp>

#include "tests/support/shown_text_cases.h"

namespace motiondb::tests::display_text_test {
namespace {

TEST_CASE("DisplayText: display controls are replaced", "[text]") {
  for (const auto& [text, shown] : DisplayedTextCases()) {
    CAPTURE(text);
    CHECK(text::SafeText(text) == shown);
    if (text.find("mdb_") == std::string::npos) CHECK(text::DisplayText(text) == shown);
  }
  for (char32_t character = 0; character <= 0x10FFFF; ++character) {
    if (text::IsDisplayControl(character) != IsListedDisplayControl(character)) {
      FAIL(static_cast<unsigned>(character));
    }
  }
  CHECK(text::DisplayLines("a\nb\x1b") == "a\nb\xEF\xBF\xBD");
  CHECK(text::DisplayText("a\nb\xC3", "?") == "a?b?");
  CHECK(text::DisplayText(AnyToken()) == AnyToken());
}

TEST_CASE("FindDisplayControl: returns the first display control", "[text]") {
  CHECK(text::FindDisplayControl("M\xC3\xBCller").bytes == 0);
  CHECK(text::FindDisplayControl("M\xC3\xBC\xE2\x80\xAE\x1b").code == 0x202E);
}

TEST_CASE("RedactSecrets: the secret after a token's id is replaced", "[text]") {
  const std::string token = "mdb_0123456789ab_" + std::string(64, 'c');
  const std::string shown = "mdb_0123456789ab_...";
  CHECK(text::RedactSecrets(token) == shown);
  CHECK(text::RedactSecrets("tokens/" + token) == "tokens/" + shown);
  CHECK(text::RedactSecrets("tokens/" + token.substr(0, 20)) == "tokens/" + shown);
  CHECK(text::RedactSecrets(token + "/" + token + "/x") == shown + "/" + shown + "/x");
  CHECK(text::RedactSecrets("mdb_mdb_0123456789AB_ g") == "mdb_mdb_0123456789AB_... g");
  CHECK(text::RedactSecrets("got '" + token + "', see") == "got '" + shown + "', see");
  for (const char* plain : {"", "tokens/0123456789ab", "databases/mdb_walks_2/clips/a", "mdb_",
                            "mdb_0123456789ab", "mdb_0123456789", "databases/mdb_0123456789a_"}) {
    CHECK(text::RedactSecrets(plain) == plain);
  }
}

}  // namespace
}  // namespace motiondb::tests::display_text_test
