#include "server/rpc/method.h"

namespace motiondb::server {

Method FindMethod(const google::protobuf::Descriptor& request_type) {
  const google::protobuf::DescriptorPool& pool = *request_type.file()->pool();
  for (const CallRule& rule : CallRules()) {
    const std::string name(rule.method);
    const auto* const method = pool.FindMethodByName("motiondb.v1." + name);
    if (method == nullptr || method->input_type() != &request_type) continue;
    return {.name = name,
            .rule = &rule,
            .streaming = method->client_streaming() || method->server_streaming(),
            .weight = rule.weight};
  }
  return {.name = request_type.name()};
}

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  for (const CallRule& rule : CallRules()) names.emplace_back(rule.method);
  return names;
}

}  // namespace motiondb::server
