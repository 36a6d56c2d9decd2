#include "server/gateway/openapi.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::MethodDescriptor;
using google::protobuf::SourceLocation;
using Json = nlohmann::ordered_json;

constexpr char kApiDescription[] =
    "Every call of motiondb.v1 by the Connect protocol (https://connectrpc.com/docs/protocol). "
    "Calls that stream requests are available with gRPC only.";

// Returns the comment of a declaration in one paragraph; empty if it has none.
template <typename Declaration>
std::string CommentOf(const Declaration& declaration) {
  SourceLocation location;
  if (!declaration.GetSourceLocation(&location)) return "";
  std::string text = location.leading_comments + location.trailing_comments;
  std::ranges::replace(text, '\n', ' ');
  const auto is_second_blank = [](char a, char b) { return a == ' ' && b == ' '; };
  text.erase(std::unique(text.begin(), text.end(), is_second_blank), text.end());
  const auto begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? ""
                                    : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

std::string FirstSentence(const std::string& text) {
  const auto end = std::min(text.find(". "), text.find(": "));
  return end == std::string::npos ? text.substr(0, text.find_last_not_of('.') + 1)
                                  : text.substr(0, end);
}

class OpenApiWriter {
 public:
  // Adds the RPC with all messages that it uses.
  void Add(const MethodDescriptor& method);
  Json Finish(const std::string& version) &&;
  // Types of google.protobuf without a mapping.
  const std::vector<std::string>& unknown() const { return unknown_; }

 private:
  Json Reference(const Descriptor& type);
  Json WellKnown(const Descriptor& type);
  Json SchemaOf(const Descriptor& type);
  Json SchemaOf(const EnumDescriptor& type);
  Json ValueOf(const FieldDescriptor& field);
  Json PropertyOf(const FieldDescriptor& field);

  Json paths_ = Json::object();
  Json schemas_ = Json::object();
  std::vector<std::pair<std::string, std::string>> tags_;
  std::set<std::string> added_;
  std::vector<std::string> unknown_;
};

Json OpenApiWriter::WellKnown(const Descriptor& type) {
  const std::string& name = type.name();
  if (name == "Timestamp") return {{"type", "string"}, {"format", "date-time"}};
  if (name == "Duration") return {{"type", "string"}, {"pattern", "^-?[0-9]+(\\.[0-9]{1,9})?s$"}};
  if (name == "FieldMask") return {{"type", "string"}};
  if (name == "Any") {
    return {{"type", "object"},
            {"properties", {{"@type", {{"type", "string"}}}}},
            {"additionalProperties", true}};
  }
  unknown_.push_back(type.full_name());
  return {};
}

Json OpenApiWriter::Reference(const Descriptor& type) {
  if (type.file()->package() == "google.protobuf") return WellKnown(type);
  if (added_.insert(type.full_name()).second) {
    schemas_[type.full_name()] = Json();  // keeps the order; a message may contain itself
    Json schema = SchemaOf(type);
    schemas_[type.full_name()] = std::move(schema);
  }
  return {{"$ref", "#/components/schemas/" + type.full_name()}};
}

Json OpenApiWriter::SchemaOf(const EnumDescriptor& type) {
  Json names = Json::array();
  std::string text = CommentOf(type);
  for (int i = 0; i < type.value_count(); ++i) {
    names.push_back(type.value(i)->name());
    const std::string comment = CommentOf(*type.value(i));
    if (!comment.empty()) text += "\n- `" + type.value(i)->name() + "`: " + comment;
  }
  return {{"type", "string"}, {"description", text}, {"enum", names}};
}

// Returns the schema of one value of the field, as the JSON mapping reads and writes it.
Json OpenApiWriter::ValueOf(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return {{"type", "boolean"}};
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_UINT32:
      return {{"type", "integer"}, {"format", "int32"}};
    case FieldDescriptor::CPPTYPE_INT64:
    case FieldDescriptor::CPPTYPE_UINT64:
      return {{"type", {"string", "integer"}}, {"format", "int64"}};
    case FieldDescriptor::CPPTYPE_FLOAT:
    case FieldDescriptor::CPPTYPE_DOUBLE:  // or "NaN", "Infinity", "-Infinity"
      return {{"type", {"number", "string"}}, {"format", "double"}};
    case FieldDescriptor::CPPTYPE_STRING:
      if (field.type() == FieldDescriptor::TYPE_STRING) return {{"type", "string"}};
      return {{"type", "string"}, {"contentEncoding", "base64"}};
    case FieldDescriptor::CPPTYPE_ENUM: {
      const EnumDescriptor& type = *field.enum_type();
      if (added_.insert(type.full_name()).second) schemas_[type.full_name()] = SchemaOf(type);
      return {{"$ref", "#/components/schemas/" + type.full_name()}};
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return Reference(*field.message_type());
  }
  return {};
}

Json OpenApiWriter::PropertyOf(const FieldDescriptor& field) {
  Json value;
  if (field.is_map()) {
    value = {{"type", "object"},
             {"additionalProperties", ValueOf(*field.message_type()->map_value())}};
  } else if (field.is_repeated()) {
    value = {{"type", "array"}, {"items", ValueOf(field)}};
  } else {
    value = ValueOf(field);
  }
  std::string comment = CommentOf(field);
  if (const auto* const choice = field.real_containing_oneof()) {
    comment += (comment.empty() ? "" : " ") +
               ("At most one field of `" + choice->name() + "` may be set.");
  }
  if (!comment.empty()) value["description"] = comment;
  return value;
}

Json OpenApiWriter::SchemaOf(const Descriptor& type) {
  Json schema = {{"type", "object"}};
  const std::string comment = CommentOf(type);
  if (!comment.empty()) schema["description"] = comment;
  Json properties = Json::object();
  for (int i = 0; i < type.field_count(); ++i) {
    properties[type.field(i)->json_name()] = PropertyOf(*type.field(i));
  }
  if (!properties.empty()) schema["properties"] = properties;
  return schema;
}

void OpenApiWriter::Add(const MethodDescriptor& method) {
  const std::string comment = CommentOf(method);
  const std::string tag = method.service()->name();
  if (tags_.empty() || tags_.back().first != tag) {
    tags_.emplace_back(tag, CommentOf(*method.service()));
  }
  const bool streams = method.server_streaming();
  const std::string type = streams ? "application/connect+" : "application/";
  const auto content = [&](const Descriptor& message) -> Json {
    return {{type + "json", {{"schema", Reference(message)}}},
            {type + "proto", {{"schema", {{"type", "string"}, {"format", "binary"}}}}}};
  };
  Json operation = {{"operationId", tag + "_" + method.name()},
                    {"tags", {tag}},
                    {"summary", FirstSentence(comment)},
                    {"description", comment}};
  if (streams) {
    operation["description"] =
        comment +
        " The request and each message of the response are in envelopes: a byte of "
        "flags, the length in 4 bytes (big-endian), and the message.";
  }
  operation["requestBody"] = {{"required", true}, {"content", content(*method.input_type())}};
  operation["responses"] = {
      {"200",
       {{"description", streams ? "The messages, in envelopes." : "The response."},
        {"content", content(*method.output_type())}}},
      {"4XX", {{"$ref", "#/components/responses/error"}}},
      {"5XX", {{"$ref", "#/components/responses/error"}}}};
  paths_["/" + method.service()->full_name() + "/" + method.name()] = {{"post", operation}};
}

// The error of the Connect protocol.
Json ErrorSchema() {
  const Json text = {{"type", "string"}};
  const Json detail = {
      {"type", "object"},
      {"properties",
       {{"type", {{"type", "string"}, {"description", "Name of the message."}}},
        {"value",
         {{"type", "string"}, {"description", "The protobuf message in base64, unpadded."}}},
        {"debug", {{"type", "object"}, {"description", "The message as JSON, for people."}}}}}};
  return {{"type", "object"},
          {"description", "An error of the Connect protocol."},
          {"required", {"code"}},
          {"properties",
           {{"code", {{"type", "string"}, {"description", "Such as `invalid_argument`."}}},
            {"message", text},
            {"details", {{"type", "array"}, {"items", detail}}}}}};
}

Json OpenApiWriter::Finish(const std::string& version) && {
  Json tags = Json::array();
  for (const auto& [name, comment] : tags_) {
    tags.push_back({{"name", name}, {"description", comment}});
  }
  schemas_["connect.error"] = ErrorSchema();
  return {{"openapi", "3.1.0"},
          {"info",
           {{"title", "motiondb"},
            {"version", version},
            {"description", kApiDescription},
            {"license", {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}}}}},
          {"servers", {{{"url", "/"}}}},
          {"security", {Json::object(), {{"token", Json::array()}}}},
          {"tags", tags},
          {"paths", paths_},
          {"components",
           {{"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}},
            {"responses",
             {{"error",
               {{"description", "The call failed."},
                {"content",
                 {{"application/json",
                   {{"schema", {{"$ref", "#/components/schemas/connect.error"}}}}}}}}}}},
            {"schemas", schemas_}}}};
}

}  // namespace

absl::StatusOr<std::string> OpenApiDocument(const google::protobuf::FileDescriptorSet& files,
                                            const std::string& version) {
  DescriptorPool pool;
  OpenApiWriter writer;
  for (const auto& proto : files.file()) {
    const auto* const file = pool.BuildFile(proto);
    if (file == nullptr) return core::InvalidArgument("{}: no valid descriptor", proto.name());
    for (int i = 0; i < file->service_count(); ++i) {
      for (int j = 0; j < file->service(i)->method_count(); ++j) {
        const MethodDescriptor& method = *file->service(i)->method(j);
        if (!method.client_streaming()) writer.Add(method);
      }
    }
  }
  if (!writer.unknown().empty()) {
    return core::InvalidArgument("{}: no known JSON mapping; add it to OpenApiWriter::WellKnown",
                                 writer.unknown().front());
  }
  return std::move(writer).Finish(version).dump(1);
}

}  // namespace motiondb::server
