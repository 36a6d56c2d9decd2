// Takes the place of server/engine/work/workers.h in the simulation: the threads of a server are
// tasks of its simulated process.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>

#include "server/engine/work/engine_options.h"
#include "server/engine/work/executor.h"
#include "tests/simulation/world.h"

namespace motiondb::server {

class Workers : public Executor {
 public:
  // Of the process of the running task.
  explicit Workers(const EngineOptions& options);
  ~Workers() override { Join(); }

  Clock::time_point Now() const override { return simulation::World::Current().now(); }
  void Post(Pool pool, Work work) override;
  std::unique_ptr<Timer> MakeTimer(Pool pool) override;
  core::ParallelFor Parallel(Pool pool) override;

  int queued(Pool pool) const { return static_cast<int>(At(pool).queue.size()); }
  void Join();

 private:
  struct Threads {
    int idle = 1;
    std::deque<Work> queue;
  };

  Threads& At(Pool pool) { return pools_[static_cast<std::size_t>(pool)]; }
  const Threads& At(Pool pool) const { return pools_[static_cast<std::size_t>(pool)]; }

  simulation::Process* const process_;
  std::array<Threads, 6> pools_;  // by Pool
  int running_ = 0;               // tasks
  simulation::WaitList all_ended_;
};

}  // namespace motiondb::server
