// The text in a field of any message. Safe to call from any thread.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

namespace motiondb::server {

// `path` is that of a string field, as "prediction.database". Empty where a message on the way is
// absent, and for the empty path. The path must be one of the message's type.
std::string FieldText(const google::protobuf::Message& message, std::string_view path);

// The field at the path in a message type; null if there is none, or it is no single string.
const google::protobuf::FieldDescriptor* FindTextField(const google::protobuf::Descriptor& type,
                                                       std::string_view path);

}  // namespace motiondb::server
