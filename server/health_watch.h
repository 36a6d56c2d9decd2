// Keeps gRPC's health service in step with the store: while additions fail, for lack of room or
// because the disk fails, the server as a whole and the services that add are NOT_SERVING. Services
// that only read stay SERVING. It looks every second, on the thread of urgent changes.
#pragma once

#include <memory>

#include "server/engine/engine.h"

namespace grpc {
class HealthCheckServiceInterface;
}  // namespace grpc

namespace motiondb::server {

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
