#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/connection_acceptor.h"
#include "server/engine/clock.h"
#include "server/reset_guard.h"
#include "server/rpc/method.h"
#include "server/rpc/reflection.h"
#include "server/rpc/services.h"
#include "server/rpc/silence_limit.h"
#include "server/security/admin_token_file.h"
#include "server/security/file_watch.h"
#include "server/security/tls.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;

// Both are process-wide and must be on before the first builder.
void EnablePlugins() {
  static const bool kEnabled = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    return true;
  }();
  (void)kEnabled;
}

// Clients that ping are not thrown off (gRPC's own limits allow two pings in five minutes, and none
// in two hours without a call), and peers that are gone are found.
void SetKeepalive(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 1000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 60'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  // Whoever connects and says nothing does not hold the connection.
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 20'000);
}

// A few kilobytes would unpack to gigabytes before anybody compares them with a limit, or looks at
// who sends them. Clients do not compress unless they are told to.
void RefuseCompression(grpc::ServerBuilder& builder) {
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
}

// Breaks off calls that were answered, and whose client takes nothing for as long as it may be
// silent, or a tenth longer.
std::unique_ptr<SilenceLimit> WatchUntaken(CallHost& host) {
  const auto longest = host.limits.options().longest_silence;
  const auto period = std::clamp(longest / 10, milliseconds(10), milliseconds(10'000));
  return std::make_unique<SilenceLimit>(
      host.engine.workers().request_executor(), period, period,
      [&gate = host.gate, longest] { gate.CancelEndedBefore(CallGate::Clock::now() - longest); });
}

// How long clients have to close their connections before they are cut.
constexpr milliseconds kFarewell{100};
constexpr int kFurtherCalls = 1000;     // of one connection, which are told that they are too many
constexpr int kOwnMetadata = 16 << 10;  // room for what gRPC and HTTP/2 add of their own

constexpr const char* kServiceNames[] = {
    "motiondb.v1.DatabaseService",  "motiondb.v1.ClipService",  "motiondb.v1.ModelService",
    "motiondb.v1.OperationService", "motiondb.v1.QueryService", "motiondb.v1.ObserveService",
    "motiondb.v1.AccessService",    "motiondb.v1.StoreService"};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(std::unique_ptr<storage::MotionStore> store,
                                                      const ServerOptions& options,
                                                      std::shared_ptr<Monitor> monitor) {
  if (monitor == nullptr) monitor = std::make_shared<Monitor>(MonitorOptions{MethodNames()});
  MOTIONDB_ASSIGN_OR_RETURN(const SecurityPlan plan,
                            PlanSecurity(options.security, options.listen));
  MOTIONDB_ASSIGN_OR_RETURN(auto engine, Engine::Open(std::move(store), options.engine));
  std::unique_ptr<Server> server(
      new Server(std::move(engine), plan.access, options.calls, std::move(monitor)));
  if (!server->host_->access.CanBeAdministered(NowMicroseconds())) {
    spdlog::warn(
        "no token of an administrator holds, so that nobody can make one: give --admin-token-file, "
        "or start once on 127.0.0.1 and make one there (`motiondb token create --role admin`)");
  }
  if (const std::string& file = options.security.admin_token_file; !file.empty()) {
    server->admin_token_ = std::make_unique<FileWatch>(
        "administrator's token", file,
        [file, &access = server->host_->access]() -> absl::StatusOr<bool> {
          MOTIONDB_ASSIGN_OR_RETURN(const std::string token, ReadAdminToken(file));
          return access.ReplaceAdminToken(token);
        });
  }
  if (options.security.tls.enabled()) {
    const auto tell_end = [&monitor = *server->monitor_](std::int64_t end_time_s) {
      monitor.SetCertificateEnd(end_time_s);
    };
    MOTIONDB_ASSIGN_OR_RETURN(server->tls_, Tls::Start(options.security.tls, tell_end));
  }
  MOTIONDB_RETURN_IF_ERROR(server->Listen(options, plan.reflection));
  return server;
}

Server::Server(std::unique_ptr<Engine> engine, const AccessOptions& access,
               const CallLimitOptions& calls, std::shared_ptr<Monitor> monitor)
    : monitor_(std::move(monitor)),
      engine_(std::move(engine)),
      attachment_(*monitor_, *engine_),
      host_(new CallHost{*engine_,
                         {engine_->store().access(), access},
                         CallLimits(calls),
                         MessageMemory(calls.message_memory_bytes),
                         {},
                         *monitor_}) {
  untaken_ = WatchUntaken(*host_);
  services_.push_back(MakeDatabaseService(*host_));
  services_.push_back(MakeClipService(*host_));
  services_.push_back(MakeModelService(*host_));
  services_.push_back(MakeOperationService(*host_));
  services_.push_back(MakeQueryService(*host_));
  services_.push_back(MakeObserveService(*host_));
  services_.push_back(MakeAccessService(*host_));
  services_.push_back(MakeStoreService(*host_));
}

Server::~Server() { Drain(milliseconds(0)); }

absl::Status Server::Listen(const ServerOptions& options, bool reflection) {
  EnablePlugins();
  grpc::ServerBuilder builder;
  using Builder = grpc::ServerBuilder::experimental_type;
  const std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor> to_grpc =
      builder.experimental().AddExternalConnectionAcceptor(
          Builder::ExternalConnectionType::FROM_FD,
          tls_ ? tls_->credentials() : grpc::InsecureServerCredentials());
  SetKeepalive(builder);
  RefuseCompression(builder);
  SetReflection(reflection, builder);
  // Beyond it calls of one connection wait in the client. CallLimits answers before; this is for
  // health checks, which it does not see.
  const int most_streams = options.calls.calls.in_all + kFurtherCalls;
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, most_streams);
  builder.SetMaxReceiveMessageSize(options.max_message_bytes);
  // A call is only known here, with its limits, when its first message is whole.
  builder.SetResourceQuota(
      grpc::ResourceQuota("motiondb")
          .Resize(static_cast<std::size_t>(options.calls.message_memory_bytes)));
  // More than a call may have (CallLimits): beyond this gRPC ends the connection without a word.
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE,
                             4 * options.calls.max_metadata_bytes + kOwnMetadata);
  for (const auto& service : services_) builder.RegisterService(service.get());
  grpc_ = builder.BuildAndStart();
  if (grpc_ == nullptr)
    return absl::InternalError("gRPC does not start; --log-level debug shows more");
  const auto take = [to_grpc](int connection, int listener) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection;
    parameters.listener_fd = listener;
    to_grpc->HandleNewConnection(&parameters);
  };
  // Twice what may be under way: those that are over take a moment to be forgotten.
  reset_guard_ =
      std::make_unique<ResetGuard>(CallLimit{2 * most_streams, options.calls.calls.per_client});
  MOTIONDB_ASSIGN_OR_RETURN(acceptor_, ConnectionAcceptor::Start(options.listen, take));
  address_ =
      fmt::format("{}:{}", options.listen.substr(0, options.listen.rfind(':')), acceptor_->port());
  for (const char* const name : kServiceNames) {
    grpc_->GetHealthCheckService()->SetServingStatus(name, true);
  }
  monitor_->SetTransport(tls_ != nullptr, host_->access.authentication());
  monitor_->SetPhase(Phase::kServing);
  return absl::OkStatus();
}

void Server::Drain(milliseconds grace) {
  if (grpc_ == nullptr) return;
  monitor_->SetPhase(Phase::kDraining);
  const auto latest = std::chrono::steady_clock::now() + grace;
  grpc_->GetHealthCheckService()->Shutdown();
  host_->gate.Close();
  // Calls that wait for an operation end with this, and builds stop.
  engine_->Drain();
  host_->gate.AwaitEmpty(latest);
  // gRPC forgets connections that come after its end.
  acceptor_.reset();
  // No call is left, or none that may stay; the moment is for clients to take notice.
  grpc_->Shutdown(std::chrono::system_clock::now() + std::min(grace, kFarewell));
}

}  // namespace motiondb::server
