#include "server/translate/plain_text.h"

#include <algorithm>
#include <cstdint>

#include "core/motion/error.h"
#include "server/translate/field_violation.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

absl::Status CheckLine(std::string_view field, std::string_view line) {
  const text::Character control = text::FindDisplayControl(line);
  if (control.bytes == 0) return absl::OkStatus();
  return FieldViolation(
      field, "expected text, got the control or invisible format character U+{:04X}; leave it out",
      static_cast<std::uint32_t>(control.code));
}

}  // namespace

absl::Status CheckNoToken(std::string_view field, std::string_view text) {
  if (text::WithoutSecrets(text) == text) return absl::OkStatus();
  return FieldViolation(
      field, "expected no access token, which everybody could read here; revoke the one you sent");
}

absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most) {
  if (text.size() > most) {
    return FieldViolation(field, "expected at most {} bytes, got {}", most, text.size());
  }
  MOTIONDB_RETURN_IF_ERROR(CheckLine(field, text));
  return CheckNoToken(field, text);
}

absl::Status CheckPlainLines(std::string_view field, std::string_view text) {
  MOTIONDB_RETURN_IF_ERROR(CheckNoToken(field, text));
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\t\r\n"), text.size());
    MOTIONDB_RETURN_IF_ERROR(CheckLine(field, text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
