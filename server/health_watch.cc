#include "server/health_watch.h"

#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>

#include "absl/cleanup/cleanup.h"
#include "server/rpc/silence_limit.h"

namespace motiondb::server {
namespace {

constexpr std::chrono::milliseconds kPeriod{1000};

// "" is the server as a whole.
constexpr const char* kNeedWrites[] = {"", "motiondb.v1.ClipService",
                                       "motiondb.v1.DatabaseService"};

}  // namespace

struct HealthWatch::State {
  std::atomic<bool> is_looking = false;
  std::mutex mutex;
  grpc::HealthCheckServiceInterface* health = nullptr;  // null: the watch has ended
  bool writes = true;
};

HealthWatch::HealthWatch(Engine& engine, grpc::HealthCheckServiceInterface& health)
    : state_(std::make_shared<State>()),
      timer_(std::make_unique<SilenceLimit>(
          engine.workers(), kPeriod, kPeriod, [&engine, state = state_] {
            // The check may wait for the disk: not on a request thread.
            if (state->is_looking.exchange(true)) return;
            engine.workers().Post(Pool::kUrgentChanges, [&engine, state] { Look(engine, state); });
          })) {
  const std::lock_guard lock(state_->mutex);
  state_->health = &health;
}

HealthWatch::~HealthWatch() {
  const std::lock_guard lock(state_->mutex);
  state_->health = nullptr;
}

void HealthWatch::Look(Engine& engine, const std::shared_ptr<State>& state) {
  const absl::Cleanup end = [&] { state->is_looking = false; };
  const absl::Status writes = engine.store().CheckWrites();
  const std::lock_guard lock(state->mutex);
  if (state->health == nullptr || state->writes == writes.ok()) return;
  state->writes = writes.ok();
  for (const char* const service : kNeedWrites) {
    state->health->SetServingStatus(service, writes.ok());
  }
  if (writes.ok()) {
    spdlog::info("the store accepts additions again");
  } else {
    spdlog::error("the store accepts no additions, queries go on: {}",
                  std::string(writes.message()));
  }
}

}  // namespace motiondb::server
