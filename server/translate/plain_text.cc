#include "server/translate/plain_text.h"

#include <algorithm>

#include "server/translate/field_violation.h"

namespace motiondb::server {
namespace {

// Of ASCII.
bool IsControl(char c) { return (c >= 0 && c < 0x20) || c == 0x7f; }

// U+0080 to U+009F, by which some terminals are controlled too.
bool IsLateControl(std::string_view text) {
  if (text.size() < 2 || text[0] != '\xc2') return false;
  const auto second = static_cast<unsigned char>(text[1]);
  return second >= 0x80 && second <= 0x9f;
}

}  // namespace

std::string WithoutControls(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const bool late = IsLateControl(text);
    if (late || IsControl(text[0])) {
      plain += "\uFFFD";
    } else {
      plain += text[0];
    }
    text.remove_prefix(late ? 2 : 1);
  }
  return plain;
}

absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most) {
  if (text.size() > most) {
    return FieldViolation(field, "expected at most {} bytes, got {}", most, text.size());
  }
  if (std::ranges::any_of(text, IsControl)) {
    return FieldViolation(field, "has a control character");
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
