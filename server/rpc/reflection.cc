#include "server/rpc/reflection.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/impl/server_initializer.h>
#include <grpcpp/server_builder.h>

#include <memory>
#include <string>

namespace motiondb::server {
namespace {

thread_local bool wanted = true;

// In the place of reflection where there is to be none.
class Nothing final : public grpc::ServerBuilderPlugin {
 public:
  std::string name() override { return "none"; }
  void InitServer(grpc::ServerInitializer*) override {}
  void Finish(grpc::ServerInitializer*) override {}
  void ChangeArguments(const std::string&, void*) override {}
};

std::unique_ptr<grpc::ServerBuilderPlugin> MakePlugin() {
  if (!wanted) return std::make_unique<Nothing>();
  return std::make_unique<grpc::reflection::ProtoServerReflectionPlugin>();
}

}  // namespace

void SetReflection(bool on) {
  wanted = on;
  static const bool kAdded = [] {
    grpc::ServerBuilder::InternalAddPluginFactory(&MakePlugin);
    return true;
  }();
  (void)kAdded;
}

}  // namespace motiondb::server
