// Answers as JSON: the proto's field names, zeros included, one object a line.
#pragma once

#include <string>

namespace google::protobuf {
class Message;
}

namespace motiondb::client {

// One line, without its line end.
std::string JsonLine(const google::protobuf::Message& message);

// The same, indented.
std::string IndentedJson(const google::protobuf::Message& message);

// A string as JSON, quoted and escaped.
std::string JsonString(const std::string& text);

// Prints one line to standard output.
void PrintJson(const google::protobuf::Message& message);

}  // namespace motiondb::client
