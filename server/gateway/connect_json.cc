#include "server/gateway/connect_json.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver.h>
#include <google/protobuf/util/type_resolver_util.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "motiondb/v1/error.pb.h"

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

namespace {

struct ConnectCode {
  const char* name;
  unsigned http_status;
};

ConnectCode CodeOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::CANCELLED:
      return {"canceled", 499};
    case grpc::StatusCode::INVALID_ARGUMENT:
      return {"invalid_argument", 400};
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return {"deadline_exceeded", 504};
    case grpc::StatusCode::NOT_FOUND:
      return {"not_found", 404};
    case grpc::StatusCode::ALREADY_EXISTS:
      return {"already_exists", 409};
    case grpc::StatusCode::PERMISSION_DENIED:
      return {"permission_denied", 403};
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return {"resource_exhausted", 429};
    case grpc::StatusCode::FAILED_PRECONDITION:
      return {"failed_precondition", 400};
    case grpc::StatusCode::ABORTED:
      return {"aborted", 409};
    case grpc::StatusCode::OUT_OF_RANGE:
      return {"out_of_range", 400};
    case grpc::StatusCode::UNIMPLEMENTED:
      return {"unimplemented", 501};
    case grpc::StatusCode::INTERNAL:
      return {"internal", 500};
    case grpc::StatusCode::UNAVAILABLE:
      return {"unavailable", 503};
    case grpc::StatusCode::DATA_LOSS:
      return {"data_loss", 500};
    case grpc::StatusCode::UNAUTHENTICATED:
      return {"unauthenticated", 401};
    default:
      return {"unknown", 500};
  }
}

// Without padding, as Connect requires.
std::string UnpaddedBase64(const std::string& bytes) {
  std::string text = absl::Base64Escape(bytes);
  text.erase(text.find_last_not_of('=') + 1);
  return text;
}

// The types of google.rpc have wire-compatible copies in motiondb.v1 (error.proto).
const google::protobuf::Descriptor* KnownType(const std::string& type) {
  constexpr std::string_view kGoogle = "google.rpc.";
  const std::string name =
      type.starts_with(kGoogle) ? "motiondb.v1." + type.substr(kGoogle.size()) : type;
  return google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(name);
}

nlohmann::json DetailJson(const google::protobuf::Any& detail) {
  const std::string type = detail.type_url().substr(detail.type_url().rfind('/') + 1);
  nlohmann::json json = {{"type", type}, {"value", UnpaddedBase64(detail.value())}};
  if (const auto* const known = KnownType(type)) {
    const auto debug = JsonFromProto(*known, detail.value());
    if (debug.ok()) json["debug"] = nlohmann::json::parse(*debug, nullptr, false);
  }
  return json;
}

nlohmann::json ErrorJson(const grpc::Status& error) {
  nlohmann::json json = {{"code", ConnectCodeName(error.error_code())}};
  if (!error.error_message().empty()) json["message"] = error.error_message();
  v1::Status details;
  if (!details.ParseFromString(error.error_details())) return json;
  for (const auto& detail : details.details()) json["details"].push_back(DetailJson(detail));
  return json;
}

std::string Dump(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

const char* ConnectCodeName(grpc::StatusCode code) { return CodeOf(code).name; }

unsigned HttpStatusOf(grpc::StatusCode code) { return CodeOf(code).http_status; }

std::string ConnectErrorJson(const grpc::Status& error) { return Dump(ErrorJson(error)); }

std::string EndOfStreamJson(const grpc::Status& status) {
  if (status.ok()) return "{}";
  return Dump({{"error", ErrorJson(status)}});
}

}  // namespace motiondb::server
