#include "server/engine/work/workers.h"

#include <utility>

namespace motiondb::server {
namespace {

using simulation::Duration;
using simulation::milliseconds;
using simulation::World;

class SimulatedTimer final : public Executor::Timer {
 public:
  SimulatedTimer(Workers& workers, Pool pool, simulation::Process* process)
      : workers_(workers), pool_(pool), process_(process) {}
  ~SimulatedTimer() override { Cancel(); }

  void Set(Executor::Clock::time_point time, Executor::Work work) override {
    Cancel();
    World& world = World::Current();
    event_ = world.At(
        std::max(time, world.now()), process_,
        [&workers = workers_, pool = pool_, work = std::move(work)] { workers.Post(pool, work); });
  }
  void Cancel() override { World::Current().Remove(std::exchange(event_, nullptr)); }

 private:
  Workers& workers_;
  const Pool pool_;
  simulation::Process* const process_;
  World::EventPointer event_;
};

}  // namespace

Workers::Workers(const EngineOptions&) : process_(World::Current().process()) {
  At(Pool::kRequests).idle = 4;
  At(Pool::kBuilds).idle = 2;
  At(Pool::kChanges).idle = 2;
}

void Workers::Post(Pool pool, Work work) {
  Threads& threads = At(pool);
  threads.queue.push_back(std::move(work));
  if (threads.idle == 0) return;
  --threads.idle;
  ++running_;
  World& world = World::Current();
  world.Start(
      process_,
      [this, &threads] {
        while (!threads.queue.empty()) {
          const Work next = std::move(threads.queue.front());
          threads.queue.pop_front();
          next();
        }
        ++threads.idle;
        if (--running_ == 0) all_ended_.WakeAll();
      },
      world.Between({}, simulation::microseconds(200)));
}

std::unique_ptr<Executor::Timer> Workers::MakeTimer(Pool pool) {
  return std::make_unique<SimulatedTimer>(*this, pool, process_);
}

core::ParallelFor Workers::Parallel(Pool) {
  return [](int count, const std::function<void(int)>& body) {
    World& world = World::Current();
    world.Sleep(world.Chance(world.hazards.long_work) ? world.Between({}, simulation::seconds(2))
                                                      : world.Between({}, milliseconds(1)));
    for (int i = 0; i < count; ++i) body(i);
  };
}

void Workers::Join() {
  while (running_ > 0) all_ended_.Wait();
}

}  // namespace motiondb::server
