#include "server/gateway/json_codec.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver.h>
#include <google/protobuf/util/type_resolver_util.h>

#include <memory>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

namespace util = google::protobuf::util;

constexpr char kUrlPrefix[] = "type.googleapis.com";

util::TypeResolver* Resolver() {
  static util::TypeResolver* const resolver = util::NewTypeResolverForDescriptorPool(
      kUrlPrefix, google::protobuf::DescriptorPool::generated_pool());
  return resolver;
}

std::string UrlOf(const google::protobuf::Descriptor& type) {
  return std::string(kUrlPrefix) + "/" + type.full_name();
}

// protobuf shows the text around an error on further lines.
std::string FirstLine(const util::Status& status) {
  const std::string text(status.message().data(), status.message().size());
  return text.substr(0, text.find('\n'));
}

}  // namespace

absl::StatusOr<std::string> ProtoFromJson(const google::protobuf::Descriptor& type,
                                          std::string_view json) {
  std::string bytes;
  if (json.empty()) return bytes;
  const util::Status status =
      util::JsonToBinaryString(Resolver(), UrlOf(type), {json.data(), json.size()}, &bytes);
  if (status.ok()) return bytes;
  return core::InvalidArgument("expected JSON of a {}: {}", type.full_name(), FirstLine(status));
}

absl::StatusOr<std::string> JsonFromProto(const google::protobuf::Descriptor& type,
                                          const std::string& bytes) {
  std::string json;
  const util::Status status = util::BinaryToJsonString(Resolver(), UrlOf(type), bytes, &json);
  if (status.ok()) return json;
  return absl::InternalError(
      fmt::format("cannot convert a {} to JSON: {}", type.full_name(), FirstLine(status)));
}

absl::Status CheckProto(const google::protobuf::Descriptor& type, const std::string& bytes) {
  const google::protobuf::Message* const prototype =
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type);
  const std::unique_ptr<google::protobuf::Message> message(prototype->New());
  if (message->ParseFromString(bytes)) return absl::OkStatus();
  return core::InvalidArgument("expected a protobuf message {}, got invalid bytes or UTF-8",
                               type.full_name());
}

}  // namespace motiondb::server
