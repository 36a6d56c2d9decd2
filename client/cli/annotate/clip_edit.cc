#include "client/cli/annotate/clip_edit.h"

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <set>

#include "absl/status/status.h"

namespace motiondb::client {

namespace {

using google::protobuf::util::TimeUtil;

bool ReadFlag(const std::string& text, v1::FieldValue& value) {
  if (text != "true" && text != "false") return false;
  value.set_flag(text == "true");
  return true;
}

bool ReadFieldNumber(const std::string& text, v1::FieldValue& value) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return false;
  value.set_number(number);
  return true;
}

bool ReadTime(const std::string& text, v1::FieldValue& value) {
  google::protobuf::Timestamp time;
  if (!TimeUtil::FromString(text, &time)) return false;
  *value.mutable_time() = time;
  return true;
}

bool ReadFieldText(const std::string& text, v1::FieldValue& value) {
  value.set_text(text);
  return true;
}

struct FieldType {
  const char* name;
  const char* expected;
  bool (*read)(const std::string& text, v1::FieldValue& value);
};

// In the order in which they are tried.
constexpr FieldType kFieldTypes[] = {{"flag", "true or false", ReadFlag},
                                     {"number", "a finite number", ReadFieldNumber},
                                     {"time", "a time as 2026-01-31T10:00:00Z", ReadTime},
                                     {"text", "a text", ReadFieldText}};

// Changes a text field of the clip and names it in the mask.
void SetText(const std::optional<std::string>& text, const char* field,
             void (v1::Clip::*set)(const std::string&), v1::UpdateClipRequest& request) {
  if (!text) return;
  (request.mutable_clip()->*set)(*text);
  request.mutable_update_mask()->add_paths(field);
}

}  // namespace

bool ClipEdit::empty() const {
  return !label && !subject && !title && !description && !ChangesTags() && fields.empty() &&
         removed_fields.empty();
}

v1::UpdateClipRequest UpdateRequest(const ClipEdit& edit, const v1::Clip& stored) {
  v1::UpdateClipRequest request;
  v1::Clip& clip = *request.mutable_clip();
  clip.set_name(stored.name());
  SetText(edit.label, "label", &v1::Clip::set_label<const std::string&>, request);
  SetText(edit.subject, "subject", &v1::Clip::set_subject<const std::string&>, request);
  SetText(edit.title, "title", &v1::Clip::set_title<const std::string&>, request);
  SetText(edit.description, "description", &v1::Clip::set_description<const std::string&>, request);
  if (edit.ChangesTags()) {
    std::set<std::string> tags(stored.tags().begin(), stored.tags().end());
    tags.insert(edit.tags.begin(), edit.tags.end());
    for (const std::string& tag : edit.removed_tags) tags.erase(tag);
    for (const std::string& tag : tags) clip.add_tags(tag);
    clip.set_etag(stored.etag());
    request.mutable_update_mask()->add_paths("tags");
  }
  for (const auto& [name, value] : edit.fields) {
    (*clip.mutable_fields())[name] = value;
    request.mutable_update_mask()->add_paths("fields." + name);
  }
  for (const std::string& name : edit.removed_fields) {
    request.mutable_update_mask()->add_paths("fields." + name);
  }
  return request;
}

v1::FieldValue GuessFieldValue(const std::string& text) {
  v1::FieldValue value;
  for (const FieldType& type : kFieldTypes) {
    if (type.read(text, value)) break;
  }
  return value;
}

absl::StatusOr<std::pair<std::string, v1::FieldValue>> ParseField(const std::string& name_and_type,
                                                                  const std::string& text) {
  const std::size_t colon = name_and_type.find(':');
  const std::string name = name_and_type.substr(0, colon);
  if (name.empty()) return absl::InvalidArgumentError("expected the name of a field");
  if (colon == std::string::npos) return std::pair(name, GuessFieldValue(text));
  const std::string type_name = name_and_type.substr(colon + 1);
  for (const FieldType& type : kFieldTypes) {
    if (type_name != type.name) continue;
    v1::FieldValue value;
    if (type.read(text, value)) return std::pair(name, value);
    return absl::InvalidArgumentError(
        fmt::format("{}: expected {}, got {}", name, type.expected, text));
  }
  return absl::InvalidArgumentError(
      fmt::format("{}: expected the type text, number, flag or time, got {}", name, type_name));
}

absl::StatusOr<std::pair<std::string, v1::FieldValue>> ParseFieldOption(const std::string& option) {
  const std::size_t equals = option.find('=');
  if (equals == std::string::npos) {
    return absl::InvalidArgumentError(
        fmt::format("expected NAME=VALUE or NAME:TYPE=VALUE, got {}", option));
  }
  return ParseField(option.substr(0, equals), option.substr(equals + 1));
}

std::string FieldValueText(const v1::FieldValue& value) {
  switch (value.value_case()) {
    case v1::FieldValue::kText:
      return value.text();
    case v1::FieldValue::kNumber:
      return fmt::format("{}", value.number());
    case v1::FieldValue::kFlag:
      return value.flag() ? "true" : "false";
    case v1::FieldValue::kTime:
      return TimeUtil::ToString(value.time());
    case v1::FieldValue::VALUE_NOT_SET:
      break;
  }
  return "";
}

namespace {

CLI::Validator FieldText() {
  return CLI::Validator(
      [](const std::string& text) {
        return std::string(ParseFieldOption(text).status().message());
      },
      "");
}

}  // namespace

void AddRepeatedOption(CLI::App& command, const char* name, std::vector<std::string>& values,
                       const char* type, const char* description) {
  command.add_option(name, values, description)->type_name(type)->allow_extra_args(false);
}

void AddFieldOption(CLI::App& command, std::vector<std::string>& fields, const char* description) {
  command.add_option("--field", fields, description)
      ->type_name("NAME[:TYPE]=VALUE")
      ->allow_extra_args(false)
      ->check(FieldText());
}

}  // namespace motiondb::client
