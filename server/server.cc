#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
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

// How long clients have to close their connections before they are cut.
constexpr std::chrono::milliseconds kFarewell{100};

constexpr const char* kServiceNames[] = {
    "motiondb.v1.DatabaseService",  "motiondb.v1.ClipService",  "motiondb.v1.ModelService",
    "motiondb.v1.OperationService", "motiondb.v1.QueryService", "motiondb.v1.ObserveService"};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(std::unique_ptr<storage::MotionStore> store,
                                                      const ServerOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(auto engine, Engine::Open(std::move(store), options.engine));
  std::unique_ptr<Server> server(new Server(std::move(engine), options));
  MOTIONDB_RETURN_IF_ERROR(server->Listen(options));
  return server;
}

Server::Server(std::unique_ptr<Engine> engine, const ServerOptions& options)
    : engine_(std::move(engine)),
      host_(new CallHost{*engine_, {engine_->store().access(), options.access},
                          CallLimits(options.calls), {}}) {
  services_.push_back(MakeDatabaseService(*host_));
  services_.push_back(MakeClipService(*host_));
  services_.push_back(MakeModelService(*host_));
  services_.push_back(MakeOperationService(*host_));
  services_.push_back(MakeQueryService(*host_));
  services_.push_back(MakeObserveService(*host_));
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
  const auto latest = std::chrono::steady_clock::now() + grace;
  grpc_->GetHealthCheckService()->Shutdown();
  host_->gate.Close();
  // Calls that wait for an operation end with this, and builds stop.
  engine_->Drain();
  host_->gate.AwaitEmpty(latest);
  // No call is left, or none that may stay; the moment is for clients to take notice.
  grpc_->Shutdown(std::chrono::system_clock::now() + std::min(grace, kFarewell));
}

}  // namespace motiondb::server
