// A running server: the engine with its gRPC services, health checks and reflection.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/engine/engine.h"
#include "server/observability/monitor.h"
#include "server/settings/settings.h"

namespace grpc {
class Server;
class Service;
}  // namespace grpc

namespace grpc {
class HealthCheckServiceInterface;
}  // namespace grpc

namespace motiondb::server {

struct ServiceContext;
class FileReloader;
class Gateway;
class HealthWatch;
class Listener;
class IdleTimer;
class Tls;

// Thread-safe. Owns the store, all threads and the socket.
class Server {
 public:
  // Opens the engine and serves. `monitor`: null creates one. Errors: those of the store, of
  // DeriveSecurityConfig, of ListenOn and of Gateway::Start.
  static absl::StatusOr<std::unique_ptr<Server>> Start(std::unique_ptr<storage::MotionStore> store,
                                                       const ServerOptions& options,
                                                       std::shared_ptr<Monitor> monitor = nullptr);
  // Drains without a grace time.
  ~Server();

  // HOST:PORT for clients.
  const std::string& address() const { return address_; }
  // URL of the HTTP API, "https://HOST:PORT"; empty: none.
  std::string web_address() const;
  Engine& engine() { return *engine_; }
  Monitor& monitor() { return *monitor_; }

  // Refuses connections, asks clients to make new calls elsewhere, and 0.2 s later refuses them
  // with UNAVAILABLE. Leaves builds to the next server. Returns when all calls have ended; after
  // `grace` they are cancelled.
  void Drain(std::chrono::milliseconds grace);

 private:
  Server(std::unique_ptr<Engine> engine, const AccessOptions& access, const CallLimitOptions& calls,
         std::shared_ptr<Monitor> monitor);
  absl::Status Listen(const ServerOptions& options, bool reflection);

  const std::shared_ptr<Monitor> monitor_;
  const std::unique_ptr<Engine> engine_;
  const Monitor::Attachment attachment_;
  const std::unique_ptr<ServiceContext> host_;
  std::unique_ptr<IdleTimer> idle_watch_;      // cancels calls with unread responses
  std::unique_ptr<FileReloader> admin_token_;  // null: no admin token file
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<Tls> tls_;  // null: plain text
  std::unique_ptr<grpc::Server> grpc_;
  std::unique_ptr<HealthWatch> health_;
  std::unique_ptr<Listener> listener_;
  std::unique_ptr<Gateway> gateway_;  // null: no HTTP API
  std::string address_;
};

// Updates gRPC's health service every second, on the thread of urgent changes. While the store
// refuses additions (disk full or failing), the server as a whole and the services that add data
// are NOT_SERVING. Read-only services stay SERVING.
class HealthWatch {
 public:
  // All services are SERVING at first. The engine must outlive the watch. The health service is not
  // used after the watch is destroyed.
  HealthWatch(Engine& engine, grpc::HealthCheckServiceInterface& health);
  ~HealthWatch();

 private:
  struct State;
  static void Check(Engine& engine, const std::shared_ptr<State>& state);

  const std::shared_ptr<State> state_;  // shared with posted work
  const std::unique_ptr<IdleTimer> timer_;
};

}  // namespace motiondb::server
