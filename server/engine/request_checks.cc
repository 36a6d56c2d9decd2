#include "server/engine/request_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>

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

namespace {

constexpr std::size_t kMaxLabelBytes = 255;  // also of a subject
constexpr std::size_t kMaxTitleBytes = 200;
constexpr std::size_t kMaxClipDescriptionBytes = 4000;
constexpr std::size_t kMaxFieldBytes = 1000;
constexpr std::size_t kMaxWordBytes = 63;
constexpr std::size_t kMaxTags = 64;
constexpr std::size_t kMaxFields = 64;
constexpr std::size_t kMaxChanges = 1000;

bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// The name of a track or the id of a segment.
absl::Status CheckSegmentWord(std::string_view field, std::string_view word) {
  const bool valid =
      !word.empty() && word.size() <= kMaxWordBytes && std::ranges::all_of(word, [](char c) {
        return IsLower(c) || IsDigit(c) || c == '-' || c == '_';
      });
  if (valid) return CheckNoToken(field, word);
  return core::FieldViolation(field, "expected 1 to 63 of a-z, 0-9, '-', '_', got '{}'",
                              text::SafeText(word));
}

absl::Status CheckTag(std::string_view field, std::string_view tag) {
  const bool valid =
      !tag.empty() && tag.size() <= kMaxWordBytes && std::ranges::all_of(tag, [](char c) {
        return IsLower(c) || IsDigit(c) || c == '-' || c == '_' || c == '.';
      });
  if (valid) return CheckNoToken(field, tag);
  return core::FieldViolation(field, "expected 1 to 63 of a-z, 0-9, '-', '_', '.', got '{}'",
                              text::SafeText(tag));
}

absl::Status CheckLabel(std::string_view field, const std::string& label) {
  if (label.empty()) {
    return core::FieldViolation(field, "expected a label; delete the segment to remove its label");
  }
  return CheckPlainText(field, label, kMaxLabelBytes);
}

absl::Status CheckTitle(std::string_view field, const std::string& title) {
  return CheckPlainText(field, title, kMaxTitleBytes);
}

absl::Status CheckDescription(std::string_view field, const std::string& text) {
  if (text.size() > kMaxClipDescriptionBytes) {
    return core::FieldViolation(field, "expected at most {} bytes, got {}",
                                kMaxClipDescriptionBytes, text.size());
  }
  return CheckPlainLines(field, text);
}

absl::Status CheckFieldName(std::string_view field, std::string_view name) {
  const bool valid =
      !name.empty() && name.size() <= kMaxWordBytes && IsLower(name.front()) &&
      std::ranges::all_of(name, [](char c) { return IsLower(c) || IsDigit(c) || c == '_'; });
  if (valid) return CheckNoToken(field, name);
  return core::FieldViolation(
      field,
      "expected a field name of 1 to 63 of a-z, 0-9, '_' that begins with a letter, got '{}'",
      text::SafeText(name));
}

absl::Status CheckFieldValue(std::string_view field, const storage::FieldValue& value) {
  if (const auto* const text = std::get_if<std::string>(&value)) {
    return CheckPlainText(field, *text, kMaxFieldBytes);
  }
  const auto* const number = std::get_if<double>(&value);
  if (number == nullptr || std::isfinite(*number)) return absl::OkStatus();
  return core::FieldViolation(field, "expected a finite number, got {}", *number);
}

// Also sorts the tags.
absl::Status CheckTags(std::string_view field, std::vector<std::string>& tags) {
  if (tags.size() > kMaxTags) {
    return core::FieldViolation(field, "expected at most {} tags, got {}", kMaxTags, tags.size());
  }
  for (std::size_t i = 0; i < tags.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(CheckTag(fmt::format("{}[{}]", field, i), tags[i]));
  }
  std::ranges::sort(tags);
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
  return absl::OkStatus();
}

absl::Status CheckFields(std::string_view field, const storage::Fields& fields) {
  if (fields.size() > kMaxFields) {
    return core::FieldViolation(field, "expected at most {} fields, got {}", kMaxFields,
                                fields.size());
  }
  for (const auto& [name, value] : fields) {
    const std::string path = fmt::format("{}[{}]", field, text::SafeText(name));
    MOTIONDB_RETURN_IF_ERROR(CheckFieldName(path, name));
    MOTIONDB_RETURN_IF_ERROR(CheckFieldValue(path, value));
  }
  return absl::OkStatus();
}

absl::Status CheckSeconds(std::string_view field, double seconds) {
  if (std::isfinite(seconds) && seconds >= 0) return absl::OkStatus();
  return core::FieldViolation(field, "expected seconds from 0, got {}", seconds);
}

absl::Status CheckConfidence(double confidence) {
  if (confidence >= 0 && confidence <= 1) return absl::OkStatus();
  return core::FieldViolation("segment.confidence", "expected 0 to 1, got {}", confidence);
}

absl::Status CheckRange(double start_seconds, std::optional<double> end_seconds) {
  MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.start_seconds", start_seconds));
  if (!end_seconds) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.end_seconds", *end_seconds));
  if (*end_seconds > start_seconds) return absl::OkStatus();
  return core::FieldViolation("segment.end_seconds", "expected more than the start, {} s, got {} s",
                              start_seconds, *end_seconds);
}

absl::Status CheckChange(storage::ClipChange& change) {
  if (change.label) MOTIONDB_RETURN_IF_ERROR(CheckLabel("clip.label", *change.label));
  if (change.subject) {
    MOTIONDB_RETURN_IF_ERROR(CheckPlainText("clip.subject", *change.subject, kMaxLabelBytes));
  }
  if (change.title) MOTIONDB_RETURN_IF_ERROR(CheckTitle("clip.title", *change.title));
  if (change.description) {
    MOTIONDB_RETURN_IF_ERROR(CheckDescription("clip.description", *change.description));
  }
  if (change.tags) MOTIONDB_RETURN_IF_ERROR(CheckTags("clip.tags", *change.tags));
  if (change.fields) MOTIONDB_RETURN_IF_ERROR(CheckFields("clip.fields", *change.fields));
  for (const auto& [name, value] : change.field) {
    MOTIONDB_RETURN_IF_ERROR(CheckFieldName("update_mask", name));
    if (!value) continue;
    MOTIONDB_RETURN_IF_ERROR(CheckFieldValue(fmt::format("clip.fields[{}]", name), *value));
  }
  return absl::OkStatus();
}

absl::Status CheckChange(const storage::SegmentCreation& creation) {
  const storage::SegmentRecord& segment = creation.segment;
  if (!segment.id.empty()) MOTIONDB_RETURN_IF_ERROR(CheckSegmentWord("segment_id", segment.id));
  MOTIONDB_RETURN_IF_ERROR(CheckSegmentWord("segment.track", segment.track));
  MOTIONDB_RETURN_IF_ERROR(CheckLabel("segment.label", segment.label));
  MOTIONDB_RETURN_IF_ERROR(CheckRange(segment.start_seconds, segment.end_seconds));
  return CheckConfidence(segment.confidence);
}

// The store checks that the segment then ends after its start.
absl::Status CheckChange(const storage::SegmentChange& change) {
  if (change.label) MOTIONDB_RETURN_IF_ERROR(CheckLabel("segment.label", *change.label));
  if (change.start_seconds) {
    MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.start_seconds", *change.start_seconds));
  }
  if (change.end_seconds && *change.end_seconds) {
    MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.end_seconds", **change.end_seconds));
  }
  return change.confidence ? CheckConfidence(*change.confidence) : absl::OkStatus();
}

absl::Status CheckChange(const storage::SegmentDeletion&) { return absl::OkStatus(); }

// The field of v1::Change that has the change.
std::string_view FieldOf(const storage::Change& change) {
  constexpr std::string_view kFields[] = {"update_clip", "create_segment", "update_segment",
                                          "delete_segment"};
  return kFields[change.index()];
}

}  // namespace

absl::Status CheckAnnotations(std::string_view field, storage::ClipRecord& clip) {
  const auto path = [&](std::string_view name) { return fmt::format("{}.{}", field, name); };
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText(path("label"), clip.label, kMaxLabelBytes));
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText(path("subject"), clip.subject, kMaxLabelBytes));
  MOTIONDB_RETURN_IF_ERROR(CheckTitle(path("title"), clip.title));
  MOTIONDB_RETURN_IF_ERROR(CheckDescription(path("description"), clip.description));
  MOTIONDB_RETURN_IF_ERROR(CheckTags(path("tags"), clip.tags));
  return CheckFields(path("fields"), clip.fields);
}

absl::Status CheckChanges(std::vector<storage::Change>& changes, EditFields fields) {
  if (changes.size() > kMaxChanges) {
    return core::FieldViolation("changes", "expected at most {} changes, got {}", kMaxChanges,
                                changes.size());
  }
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const absl::Status valid =
        std::visit([](auto& change) { return CheckChange(change); }, changes[i]);
    if (valid.ok()) continue;
    if (fields == EditFields::kOneChange) return valid;
    return core::Within(fmt::format("changes[{}].{}", i, FieldOf(changes[i])), valid);
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
