#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <thread>
#include <utility>

#include "core/motion/error.h"
#include "server/rpc/services.h"

namespace motiondb::server {
namespace {

// Both are process-wide and must be on before the first builder.
void EnablePlugins() {
  static const bool kEnabled = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    return true;
  }();
  (void)kEnabled;
}

constexpr const char* kServiceNames[] = {"motiondb.v1.DatabaseService", "motiondb.v1.ClipService",
                                         "motiondb.v1.ModelService", "motiondb.v1.OperationService",
                                         "motiondb.v1.QueryService"};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(std::unique_ptr<storage::MotionStore> store,
                                                      const ServerOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(auto engine, Engine::Open(std::move(store), options.engine));
  std::unique_ptr<Server> server(new Server(std::move(engine)));
  MOTIONDB_RETURN_IF_ERROR(server->Listen(options));
  return server;
}

Server::Server(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {
  services_.push_back(MakeDatabaseService(*engine_));
  services_.push_back(MakeClipService(*engine_));
  services_.push_back(MakeModelService(*engine_));
  services_.push_back(MakeOperationService(*engine_));
  services_.push_back(MakeQueryService(*engine_));
}

Server::~Server() { Drain(std::chrono::milliseconds(0)); }

absl::Status Server::Listen(const ServerOptions& options) {
  EnablePlugins();
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &port);
  // Two servers on one port would share its calls between two stores.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.SetMaxReceiveMessageSize(options.max_message_bytes);
  for (const auto& service : services_) builder.RegisterService(service.get());
  grpc_ = builder.BuildAndStart();
  if (grpc_ == nullptr || port == 0) {
    return absl::UnavailableError(fmt::format("cannot listen on {}", options.listen));
  }
  address_ = fmt::format("{}:{}", options.listen.substr(0, options.listen.rfind(':')), port);
  for (const char* const name : kServiceNames) {
    grpc_->GetHealthCheckService()->SetServingStatus(name, true);
  }
  return absl::OkStatus();
}

void Server::Drain(std::chrono::milliseconds grace) {
  if (grpc_ == nullptr) return;
  grpc_->GetHealthCheckService()->Shutdown();
  // Beside each other: calls that wait for an operation end with the engine's drain, and a build
  // that takes a while to stop must not keep the door open.
  std::thread draining([this] { engine_->Drain(); });
  grpc_->Shutdown(std::chrono::system_clock::now() + grace);
  draining.join();
}

}  // namespace motiondb::server
