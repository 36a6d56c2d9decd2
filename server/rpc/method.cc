#include "server/rpc/method.h"

namespace motiondb::server {

Method FindMethod(const google::protobuf::Descriptor& request_type) {
  const google::protobuf::FileDescriptor& file = *request_type.file();
  for (int i = 0; i < file.service_count(); ++i) {
    const google::protobuf::ServiceDescriptor& service = *file.service(i);
    for (int j = 0; j < service.method_count(); ++j) {
      const google::protobuf::MethodDescriptor& method = *service.method(j);
      if (method.input_type() != &request_type) continue;
      Method found{service.name() + "." + method.name()};
      found.rule = FindCallRule(found.name);
      found.streaming = method.client_streaming() || method.server_streaming();
      found.weight = WeightOf(found.name);
      return found;
    }
  }
  return {request_type.name()};
}

}  // namespace motiondb::server
