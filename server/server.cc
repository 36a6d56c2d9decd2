#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/impl/server_builder_option.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "server/gateway/gateway.h"
#include "server/http2/call_bridge.h"
#include "server/http2/connection.h"
#include "server/listen/listener.h"
#include "server/rpc/call_identity.h"
#include "server/rpc/other_servers.h"
#include "server/rpc/parking.h"
#include "server/rpc/services.h"
#include "server/security/operator_files.h"
#include "server/security/tls.h"
#include "storage/mutex.h"

namespace motiondb::server {

namespace {

using std::chrono::milliseconds;

using grpc::reflection::ProtoServerReflectionPlugin;

class WithoutReflection final : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    const std::string name = ProtoServerReflectionPlugin().name();
    std::erase_if(*plugins, [&](const auto& plugin) { return plugin->name() == name; });
  }
};

// Switches grpc.reflection.v1alpha on or off, before the server is built. gRPC's plugin is
// process-wide and part of every builder.
void SetReflection(bool on, grpc::ServerBuilder& builder) {
  if (!on) builder.SetOption(std::make_unique<WithoutReflection>());
}

// Both plugins are process-wide and must be enabled before the first builder.
void EnablePlugins() {
  static const bool kEnabled = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    return true;
  }();
  (void)kEnabled;
}

// Cancels ended calls whose client has not read the response within the idle timeout, or up to a
// tenth later.
std::unique_ptr<IdleTimer> WatchUnreadResponses(ServiceContext& host) {
  const auto longest = host.limits.options().idle_limit;
  const auto period = std::clamp(longest / 10, milliseconds(10), milliseconds(10'000));
  return std::make_unique<IdleTimer>(
      host.engine.workers(), period, period, [&registry = host.registry, longest] {
        registry.CancelEndedBefore(CallRegistry::Clock::now() - longest);
      });
}

// Time for clients and proxies to make new calls elsewhere before the server refuses them.
constexpr milliseconds kNoticeTime{200};

// Time for clients to close their connections before the server closes them.
constexpr milliseconds kCloseTime{100};

// Returns the memory budget for messages in transit of all clients, in bytes. One client may use
// half of it.
std::int64_t TransportMemory(const CallLimitOptions& calls) {
  constexpr std::int64_t kMax = 192 << 20;
  return std::min(calls.message_memory_bytes, kMax);
}

// Returns the name of the server among those that share its store; empty if none do.
std::string SharedName(Engine& engine) { return engine.store().is_shared() ? engine.name() : ""; }

std::shared_ptr<OtherServers> MakeOtherServers(Engine& engine) {
  if (!engine.store().is_shared()) return nullptr;
  return std::make_shared<OtherServers>(engine.store(), engine.workers(), engine.name());
}

// Returns the address at which other servers of the store reach this one; empty: none.
std::string AdvertisedAddress(const ServerOptions& options, const std::string& address) {
  if (!options.advertise.empty()) return options.advertise;
  if (!address.starts_with("0.0.0.0:") && !address.starts_with("[::]:")) return address;
  spdlog::warn(
      "the other servers of the store cannot reach the streams of this one: set --advertise");
  return "";
}

constexpr const char* kServiceNames[] = {
    "motiondb.v1.DatabaseService", "motiondb.v1.ClipService",    "motiondb.v1.ModelService",
    "motiondb.v1.SegmentService",  "motiondb.v1.EditService",    "motiondb.v1.OperationService",
    "motiondb.v1.QueryService",    "motiondb.v1.ObserveService", "motiondb.v1.AccessService",
    "motiondb.v1.StoreService",    "motiondb.v1.ServerService",  "motiondb.v1.MarkerSetService",
    "motiondb.v1.ViewService"};

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> Server::Start(std::unique_ptr<storage::MotionStore> store,
                                                      const ServerOptions& options,
                                                      std::shared_ptr<Monitor> monitor) {
  if (monitor == nullptr) monitor = std::make_shared<Monitor>(MonitorOptions{MethodNames()});
  MOTIONDB_ASSIGN_OR_RETURN(
      const SecurityConfig plan,
      DeriveSecurityConfig(options.security, options.listen, options.web_listen));
  MOTIONDB_ASSIGN_OR_RETURN(auto engine, Engine::Open(std::move(store), options.engine));
  std::unique_ptr<Server> server(
      new Server(std::move(engine), plan.access, options.calls, std::move(monitor)));
  // On an error, the next look of the engine tries again.
  server->engine_->AddFollower(
      [&tokens = server->host_->access.tokens()] { tokens.FollowRevocations().IgnoreError(); });
  if (const auto& others = server->host_->others; others != nullptr) {
    server->engine_->AddFollower([&others = *others] { others.Announce(); });
  }
  if (!server->host_->access.HasAdminAccess(NowMicroseconds())) {
    spdlog::warn(
        "no valid admin token exists: set --admin-token-file, or start once on 127.0.0.1 and "
        "create one there with `motiondb token create --role admin`");
  }
  if (const std::string& file = options.security.admin_token_file; !file.empty()) {
    server->admin_token_ = std::make_unique<FileReloader>(
        "administrator's token", file,
        [file, &access = server->host_->access]() -> absl::StatusOr<bool> {
          MOTIONDB_ASSIGN_OR_RETURN(const std::string token, ReadAdminToken(file));
          return access.ReplaceAdminToken(token);
        });
  }
  if (options.security.tls.enabled()) {
    const auto set_end = [&monitor = *server->monitor_](std::int64_t end_time_s) {
      monitor.SetCertificateExpiry(end_time_s);
    };
    MOTIONDB_ASSIGN_OR_RETURN(server->tls_, Tls::Start(options.security.tls, set_end));
  }
  MOTIONDB_RETURN_IF_ERROR(server->Listen(options, plan.reflection));
  if (const auto& others = server->host_->others; others != nullptr) {
    MOTIONDB_RETURN_IF_ERROR(
        others->Begin(AdvertisedAddress(options, server->address_), options.security));
  }
  server->health_ =
      std::make_unique<HealthWatch>(*server->engine_, *server->grpc_->GetHealthCheckService());
  return server;
}

Server::Server(std::unique_ptr<Engine> engine, const AccessOptions& access,
               const CallLimitOptions& calls, std::shared_ptr<Monitor> monitor)
    : monitor_(std::move(monitor)),
      engine_(std::move(engine)),
      attachment_(*monitor_, *engine_),
      host_(new ServiceContext{*engine_,
                               {engine_->store().access(), access},
                               CallLimits(calls),
                               CallMemory(calls.message_memory_bytes),
                               {},
                               *monitor_,
                               RunningStreams(SharedName(*engine_)),
                               MakeOtherServers(*engine_)}) {
  idle_watch_ = WatchUnreadResponses(*host_);
  services_.push_back(MakeDatabaseService(*host_));
  services_.push_back(MakeMarkerSetService(*host_));
  services_.push_back(MakeClipService(*host_));
  services_.push_back(MakeSegmentService(*host_));
  services_.push_back(MakeEditService(*host_));
  services_.push_back(MakeModelService(*host_));
  services_.push_back(MakeViewService(*host_));
  services_.push_back(MakeOperationService(*host_));
  services_.push_back(MakeQueryService(*host_));
  services_.push_back(MakeObserveService(*host_));
  services_.push_back(MakeAccessService(*host_));
  services_.push_back(MakeStoreService(*host_));
  services_.push_back(MakeServerService(*host_));
}

Server::~Server() {
  Drain(milliseconds(0));
  engine_->Drain();  // also if the server has never listened: looks use the tokens
}

absl::Status Server::Listen(const ServerOptions& options, bool reflection) {
  EnablePlugins();
  grpc::ServerBuilder builder;
  SetReflection(reflection, builder);
  builder.SetMaxReceiveMessageSize(options.max_message_bytes);
  for (const auto& service : services_) builder.RegisterService(service.get());
  // gRPC has no port: all calls come from the listener through the in-process channel.
  grpc_ = builder.BuildAndStart();
  if (grpc_ == nullptr)
    return absl::InternalError("gRPC did not start; see the log with --log-level debug");
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // responses have their own limits
  const auto bridge = std::make_shared<CallBridge>(
      grpc::GenericStub(grpc_->InProcessChannel(arguments)), TransportMemory(options.calls),
      host_->limits, static_cast<std::uint32_t>(options.max_message_bytes), *monitor_);
  const auto make_http2 = [bridge](AcceptedClient client) {
    return std::make_shared<Connection>(*bridge, std::move(client));
  };
  MOTIONDB_ASSIGN_OR_RETURN(listener_, Listener::Start(options.listen, {.tls = tls_.get()},
                                                       make_http2, monitor_->connections()));
  if (!options.web_listen.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(gateway_, Gateway::Start({.listen = options.web_listen,
                                                        .tls = tls_.get(),
                                                        .web_root = options.web_root},
                                                       *host_, bridge));
  }
  address_ =
      fmt::format("{}:{}", options.listen.substr(0, options.listen.rfind(':')), listener_->port());
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
  health_.reset();
  grpc_->GetHealthCheckService()->Shutdown();
  if (listener_ != nullptr) listener_->BeginDrain();
  if (gateway_ != nullptr) gateway_->BeginDrain();
  std::this_thread::sleep_for(std::min(grace, kNoticeTime));
  host_->registry.Close();
  // Ends calls that wait for an operation, and stops builds.
  engine_->Drain();
  host_->registry.AwaitEmpty(latest);
  // All calls have ended or `grace` is over. Clients get a moment to close their connections.
  const milliseconds close_time = std::min(grace, kCloseTime);
  if (listener_ != nullptr) listener_->Close(close_time);
  if (gateway_ != nullptr) gateway_->Close(close_time);
  grpc_->Shutdown(std::chrono::system_clock::now() + close_time);
  listener_.reset();
  gateway_.reset();
}

std::string Server::web_address() const {
  if (gateway_ == nullptr) return "";
  return fmt::format("{}://{}", tls_ == nullptr ? "http" : "https", gateway_->address());
}

namespace {

constexpr std::chrono::milliseconds kCheckPeriod{1000};

// Services that are NOT_SERVING while writes fail; "" is the server as a whole.
constexpr const char* kWritingServices[] = {
    "", "motiondb.v1.ClipService", "motiondb.v1.DatabaseService", "motiondb.v1.EditService",
    "motiondb.v1.SegmentService"};

}  // namespace

struct HealthWatch::State {
  std::atomic<bool> is_checking = false;
  storage::Mutex mutex;
  grpc::HealthCheckServiceInterface* health ABSL_GUARDED_BY(mutex) =
      nullptr;  // null: the watch has ended
  bool writes ABSL_GUARDED_BY(mutex) = true;
};

HealthWatch::HealthWatch(Engine& engine, grpc::HealthCheckServiceInterface& health)
    : state_(std::make_shared<State>()),
      timer_(std::make_unique<IdleTimer>(
          engine.workers(), kCheckPeriod, kCheckPeriod, [&engine, state = state_] {
            // The check may block on the disk, so it must not run on a request thread.
            if (state->is_checking.exchange(true)) return;
            engine.workers().Post(Pool::kChanges, [&engine, state] { Check(engine, state); });
          })) {
  const storage::MutexLock lock(state_->mutex);
  state_->health = &health;
}

HealthWatch::~HealthWatch() {
  const storage::MutexLock lock(state_->mutex);
  state_->health = nullptr;
}

void HealthWatch::Check(Engine& engine, const std::shared_ptr<State>& state) {
  const absl::Cleanup end = [&] { state->is_checking = false; };
  const absl::Status writes = engine.store().CheckWrites();
  const storage::MutexLock lock(state->mutex);
  if (state->health == nullptr || state->writes == writes.ok()) return;
  state->writes = writes.ok();
  for (const char* const service : kWritingServices) {
    state->health->SetServingStatus(service, writes.ok());
  }
  if (writes.ok()) {
    spdlog::info("store accepts additions again");
  } else {
    spdlog::error("store refuses additions, queries continue: {}", std::string(writes.message()));
  }
}

}  // namespace motiondb::server
