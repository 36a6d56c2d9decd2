#include "client/cli/json_output.h"

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <cstdio>

#include "text/display_text.h"

namespace motiondb::client {
namespace {

std::string Json(const google::protobuf::Message& message, bool indented) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  options.add_whitespace = indented;
  std::string json;
  // Fails only on an Any of a type that is not linked in: OperationJson leaves those out.
  (void)google::protobuf::util::MessageToJsonString(message, &json, options);
  return text::EscapedJson(json);
}

}  // namespace

std::string JsonLine(const google::protobuf::Message& message) { return Json(message, false); }

std::string IndentedJson(const google::protobuf::Message& message) { return Json(message, true); }

std::string JsonString(const std::string& text) {
  google::protobuf::Value value;
  value.set_string_value(text);
  return Json(value, false);
}

void PrintJson(const google::protobuf::Message& message) {
  fmt::print("{}\n", JsonLine(message));
  // A reader at the other end of a pipe sees each answer when it comes.
  std::fflush(stdout);
}

}  // namespace motiondb::client
