#include "server/translate/request_info.h"

#include "motiondb/v1/error.pb.h"

namespace motiondb::server {

grpc::Status WithRequestInfo(const grpc::Status& error, const std::string& request_id) {
  v1::Status details;
  // Details that are there were made by ToGrpcStatus; where there are none the rest is filled in.
  if (error.error_details().empty() || !details.ParseFromString(error.error_details())) {
    details.set_code(error.error_code());
    details.set_message(error.error_message());
  }
  v1::RequestInfo info;
  info.set_request_id(request_id);
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url(kRequestInfoUrl);
  detail.set_value(info.SerializeAsString());
  return {error.error_code(), error.error_message(), details.SerializeAsString()};
}

}  // namespace motiondb::server
