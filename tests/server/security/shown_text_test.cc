#include "server/security/shown_text.h"

#include <catch2/catch.hpp>

#include "core/format/text_encoding.h"
#include "tests/support/shown_text_cases.h"

namespace motiondb::tests {
namespace {

TEST_CASE("ShownText: no display controls and no secrets", "[security]") {
  for (const auto& [text, shown] : ShownTexts()) {
    CAPTURE(text);
    CHECK(server::ShownText(text) == shown);
  }
  for (char32_t character = 0; character <= 0x10FFFF; ++character) {
    if (core::IsDisplayControl(character) != IsListedDisplayControl(character)) {
      FAIL(static_cast<unsigned>(character));
    }
  }
}

}  // namespace
}  // namespace motiondb::tests
