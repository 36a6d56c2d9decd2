#include "server/gateway/connect_error.h"

#include <google/protobuf/descriptor.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "absl/strings/escaping.h"
#include "motiondb/v1/error.pb.h"
#include "server/gateway/json_codec.h"

namespace motiondb::server {
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
