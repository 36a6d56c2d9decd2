#include "server/rpc/reflection.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/impl/server_builder_option.h>

#include <memory>
#include <vector>

namespace motiondb::server {
namespace {

using grpc::reflection::ProtoServerReflectionPlugin;

class WithoutReflection final : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    const std::string name = ProtoServerReflectionPlugin().name();
    std::erase_if(*plugins, [&](const auto& plugin) { return plugin->name() == name; });
  }
};

}  // namespace

void SetReflection(bool on, grpc::ServerBuilder& builder) {
  if (!on) builder.SetOption(std::make_unique<WithoutReflection>());
}

}  // namespace motiondb::server
