#include "server/translate/plain_text.h"

#include <algorithm>

#include "server/translate/field_violation.h"

namespace motiondb::server {

absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most) {
  if (text.size() > most) {
    return FieldViolation(field, "expected at most {} bytes, got {}", most, text.size());
  }
  const auto is_control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; };
  if (std::ranges::any_of(text, is_control)) {
    return FieldViolation(field, "has a control character");
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
