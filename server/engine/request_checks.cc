#include "server/engine/request_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/format/plausibility.h"
#include "core/motion/error.h"
#include "text/display_text.h"

namespace motiondb::server {

absl::Status CheckPositive(std::string_view field, double value) {
  if (std::isfinite(value) && value > 0) return absl::OkStatus();
  return core::FieldViolation(field, "expected a finite number above 0, got {}", value);
}

namespace {

absl::Status CheckLine(std::string_view field, std::string_view line) {
  const text::Character control = text::FindDisplayControl(line);
  if (control.bytes == 0) return absl::OkStatus();
  return core::FieldViolation(
      field, "expected text, got the control or invisible format character U+{:04X}; omit it",
      static_cast<std::uint32_t>(control.code));
}

}  // namespace

absl::Status CheckNoToken(std::string_view field, std::string_view text) {
  if (text::RedactSecrets(text) == text) return absl::OkStatus();
  return core::FieldViolation(
      field, "expected no access token, because other users can read this field; revoke the token");
}

absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes) {
    return core::FieldViolation(field, "expected at most {} bytes, got {}", max_bytes, text.size());
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

absl::Status CheckSkeletonFile(std::string_view prefix, core::FileFormat format,
                               std::string_view skeleton_file_name) {
  const std::string field = fmt::format("{}.skeleton_file_name", prefix);
  if (format == core::FileFormat::kAmc && skeleton_file_name.empty()) {
    return core::FieldViolation(field, "expected the ASF skeleton file of the AMC file");
  }
  if (core::InfoOf(format).skeleton.empty() && !skeleton_file_name.empty()) {
    return core::FieldViolation(field, "only AMC and CSV files have a skeleton file; omit '{}'",
                                skeleton_file_name);
  }
  return absl::OkStatus();
}

absl::Status CheckConventions(std::string_view prefix, const core::ReadOptions& given,
                              std::optional<double> leg_length_m, bool force) {
  constexpr std::size_t kMaxTakeBytes = 255;
  const auto field = [&](std::string_view name) {
    return fmt::format("{}.conventions.{}", prefix, name);
  };
  if (given.metres_per_unit) {
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("metres_per_unit"), *given.metres_per_unit));
  }
  if (given.frame_rate_hz) {
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("frame_rate_hz"), *given.frame_rate_hz));
  }
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText(field("take"), given.take, kMaxTakeBytes));
  if (!leg_length_m) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("leg_length_m"), *leg_length_m));
  if (force) return absl::OkStatus();
  return core::AtField(field("leg_length_m"), core::CheckGivenLegLength(*leg_length_m));
}

}  // namespace motiondb::server
