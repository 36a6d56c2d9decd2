#include "server/translate/annotation_values.h"

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/translate/message_fields.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxTitleBytes = 200;
constexpr std::size_t kMaxClipDescriptionBytes = 4000;
constexpr std::size_t kMaxFieldBytes = 1000;
constexpr std::size_t kMaxTagBytes = 63;
constexpr int kMaxTags = 64;
constexpr int kMaxFields = 64;

bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

absl::Status CheckTag(std::string_view field, std::string_view tag) {
  const bool valid =
      !tag.empty() && tag.size() <= kMaxTagBytes && std::ranges::all_of(tag, [](char c) {
        return IsLower(c) || IsDigit(c) || c == '-' || c == '_' || c == '.';
      });
  if (valid) return CheckNoToken(field, tag);
  return FieldViolation(field, "expected 1 to 63 of a-z, 0-9, '-', '_', '.', got '{}'",
                        text::SafeText(tag));
}

}  // namespace

absl::Status CheckTitle(std::string_view field, const std::string& title) {
  return CheckPlainText(field, title, kMaxTitleBytes);
}

absl::Status CheckDescription(std::string_view field, const std::string& text) {
  if (text.size() > kMaxClipDescriptionBytes) {
    return FieldViolation(field, "expected at most {} bytes, got {}", kMaxClipDescriptionBytes,
                          text.size());
  }
  return CheckPlainLines(field, text);
}

absl::Status CheckFieldName(std::string_view field, std::string_view name) {
  const bool valid =
      !name.empty() && name.size() <= kMaxTagBytes && IsLower(name.front()) &&
      std::ranges::all_of(name, [](char c) { return IsLower(c) || IsDigit(c) || c == '_'; });
  if (valid) return CheckNoToken(field, name);
  return FieldViolation(
      field,
      "expected a field name of 1 to 63 of a-z, 0-9, '_' that begins with a letter, got '{}'",
      text::SafeText(name));
}

absl::StatusOr<storage::FieldValue> ParseFieldValue(std::string_view field,
                                                    const v1::FieldValue& value) {
  switch (value.value_case()) {
    case v1::FieldValue::kText:
      MOTIONDB_RETURN_IF_ERROR(CheckPlainText(field, value.text(), kMaxFieldBytes));
      return storage::FieldValue(value.text());
    case v1::FieldValue::kNumber:
      if (!std::isfinite(value.number())) {
        return FieldViolation(field, "expected a finite number, got {}", value.number());
      }
      return storage::FieldValue(value.number());
    case v1::FieldValue::kFlag:
      return storage::FieldValue(value.flag());
    case v1::FieldValue::kTime: {
      constexpr std::int64_t kFirst = -62'135'596'800;  // of google.protobuf.Timestamp
      constexpr std::int64_t kLast = 253'402'300'799;
      const auto& time = value.time();
      if (time.seconds() < kFirst || time.seconds() > kLast || time.nanos() < 0 ||
          time.nanos() > 999'999'999) {
        return FieldViolation(field, "expected a time of the years 1 to 9999");
      }
      return storage::FieldValue(
          storage::FieldTime{time.seconds() * 1'000'000 + time.nanos() / 1000});
    }
    case v1::FieldValue::VALUE_NOT_SET:
      break;
  }
  return FieldViolation(field, "expected one of text, number, flag, time");
}

absl::StatusOr<std::vector<std::string>> ParseTags(std::string_view field, const GivenTags& given) {
  if (given.size() > kMaxTags) {
    return FieldViolation(field, "expected at most {} tags, got {}", kMaxTags, given.size());
  }
  for (int i = 0; i < given.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(CheckTag(fmt::format("{}[{}]", field, i), given[i]));
  }
  std::vector<std::string> tags(given.begin(), given.end());
  std::ranges::sort(tags);
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
  return tags;
}

absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given) {
  if (given.size() > kMaxFields) {
    return FieldViolation(field, "expected at most {} fields, got {}", kMaxFields, given.size());
  }
  storage::Fields fields;
  for (const auto& [name, value] : given) {
    const std::string path = fmt::format("{}[{}]", field, text::SafeText(name));
    MOTIONDB_RETURN_IF_ERROR(CheckFieldName(path, name));
    MOTIONDB_ASSIGN_OR_RETURN(fields[name], ParseFieldValue(path, value));
  }
  return fields;
}

}  // namespace motiondb::server
