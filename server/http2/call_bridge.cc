#include "server/http2/call_bridge.h"

#include "server/rpc/call_identity.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {

grpc::Status CallBridge::Refuse(std::string_view path, const grpc::Status& error,
                                const std::string& request_id, const std::string& peer) const {
  constexpr std::string_view kPackage = "/motiondb.v1.";
  std::string method(path.starts_with(kPackage) ? path.substr(kPackage.size()) : path);
  if (const std::size_t slash = method.find('/'); slash != std::string::npos) method[slash] = '.';
  const std::string id = UsableRequestId(request_id);
  CallWatch(monitor, method, CallKind::kWork)
      .End(static_cast<absl::StatusCode>(error.error_code()), error.error_message(), id, peer);
  return WithRequestInfo(error, id);
}

}  // namespace motiondb::server
