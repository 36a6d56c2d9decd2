#include "server/translate/message_fields.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "text/display_text.h"

namespace motiondb::server {

absl::Status CheckPositive(std::string_view field, double value) {
  if (std::isfinite(value) && value > 0) return absl::OkStatus();
  return FieldViolation(field, "expected a finite number above 0, got {}", value);
}

namespace {

absl::Status CheckLine(std::string_view field, std::string_view line) {
  const text::Character control = text::FindDisplayControl(line);
  if (control.bytes == 0) return absl::OkStatus();
  return FieldViolation(
      field, "expected text, got the control or invisible format character U+{:04X}; omit it",
      static_cast<std::uint32_t>(control.code));
}

}  // namespace

absl::Status CheckNoToken(std::string_view field, std::string_view text) {
  if (text::RedactSecrets(text) == text) return absl::OkStatus();
  return FieldViolation(
      field, "expected no access token, because other users can read this field; revoke the token");
}

absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes) {
    return FieldViolation(field, "expected at most {} bytes, got {}", max_bytes, text.size());
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

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::string FieldText(const Message& message, std::string_view path) {
  if (path.empty()) return "";
  const std::size_t end = path.find('.');
  const std::string name(path.substr(0, end));
  const FieldDescriptor* const field = message.GetDescriptor()->FindFieldByName(name);
  if (end == std::string_view::npos) return message.GetReflection()->GetString(message, field);
  if (!message.GetReflection()->HasField(message, field)) return "";
  return FieldText(message.GetReflection()->GetMessage(message, field), path.substr(end + 1));
}

const FieldDescriptor* FindTextField(const Descriptor& type, std::string_view path) {
  const std::size_t end = path.find('.');
  const FieldDescriptor* const field = type.FindFieldByName(std::string(path.substr(0, end)));
  if (field == nullptr || field->is_repeated()) return nullptr;
  if (end == std::string_view::npos) {
    return field->cpp_type() == FieldDescriptor::CPPTYPE_STRING ? field : nullptr;
  }
  if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) return nullptr;
  return FindTextField(*field->message_type(), path.substr(end + 1));
}

}  // namespace motiondb::server
