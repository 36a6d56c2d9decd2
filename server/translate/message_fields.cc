#include "server/translate/message_fields.h"

#include <google/protobuf/descriptor.h>

namespace motiondb::server {

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
