// A running server: the engine behind gRPC, with health checks and reflection.
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

struct CallHost;
class FileWatch;
class HealthWatch;
class Listener;
class SilenceLimit;
class Tls;

// Thread-safe. Owns the store, all threads and the socket.
class Server {
 public:
  // Opens the engine and answers from then on. The monitor, one of its own where it is null, sees
  // the server from here to its end. Codes: those of the store, of PlanSecurity and of ListenOn.
  static absl::StatusOr<std::unique_ptr<Server>> Start(std::unique_ptr<storage::MotionStore> store,
                                                       const ServerOptions& options,
                                                       std::shared_ptr<Monitor> monitor = nullptr);
  // Ends at once what still runs.
  ~Server();

  // HOST:PORT that clients reach it at.
  const std::string& address() const { return address_; }
  Engine& engine() { return *engine_; }
  Monitor& monitor() { return *monitor_; }

  // Says NOT_SERVING to health checks, answers new calls with UNAVAILABLE, leaves builds to the
  // next server, and returns when all calls have ended; those that have not after `grace` are
  // cancelled.
  void Drain(std::chrono::milliseconds grace);

 private:
  Server(std::unique_ptr<Engine> engine, const AccessOptions& access, const CallLimitOptions& calls,
         std::shared_ptr<Monitor> monitor);
  absl::Status Listen(const ServerOptions& options, bool reflection);

  const std::shared_ptr<Monitor> monitor_;
  const std::unique_ptr<Engine> engine_;
  const Monitor::Attachment attachment_;
  const std::unique_ptr<CallHost> host_;
  std::unique_ptr<SilenceLimit> untaken_;   // looks after answers that nobody takes
  std::unique_ptr<FileWatch> admin_token_;  // null: there is no file of it
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<Tls> tls_;  // null: plain text
  std::unique_ptr<grpc::Server> grpc_;
  std::unique_ptr<HealthWatch> health_;
  std::unique_ptr<Listener> listener_;
  std::string address_;
};

// Keeps gRPC's health service in step with the store: while additions fail, for lack of room or
// because the disk fails, the server as a whole and the services that add are NOT_SERVING. Services
// that only read stay SERVING. It looks every second, on the thread of urgent changes.
class SilenceLimit;

class HealthWatch {
 public:
  // All services are SERVING at first. The engine must outlive the watch; the health service is not
  // used after its destruction.
  HealthWatch(Engine& engine, grpc::HealthCheckServiceInterface& health);
  ~HealthWatch();

 private:
  struct State;
  static void Look(Engine& engine, const std::shared_ptr<State>& state);

  const std::shared_ptr<State> state_;  // shared with work that is posted
  const std::unique_ptr<SilenceLimit> timer_;
};

}  // namespace motiondb::server
