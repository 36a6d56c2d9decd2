// Simulated time and scheduling. Work runs on the thread that calls RunUntil, in order of its time;
// the seed decides the order of work due at the same time. Only RunUntil advances the clock.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <random>

#include "server/engine/work/executor.h"

namespace motiondb::tests {

class SimulatedExecutor : public server::Executor {
 public:
  explicit SimulatedExecutor(unsigned seed) : random_(seed) {}

  Clock::time_point Now() const override { return now_; }
  void Post(server::Pool, Work work) override { Add(now_, std::move(work)); }
  std::unique_ptr<Timer> MakeTimer(server::Pool) override {
    return std::make_unique<SimulatedTimer>(*this);
  }
  // Calls `between` before each body, to simulate other threads.
  core::ParallelFor Parallel(server::Pool) override {
    return [this](int count, const std::function<void(int)>& body) {
      for (int i = 0; i < count; ++i) {
        if (between) between();
        body(i);
      }
    };
  }

  void RunUntil(Clock::time_point end) {
    while (!work_.empty() && work_.begin()->first.first <= end) {
      now_ = std::max(now_, work_.begin()->first.first);
      const Work work = std::move(work_.begin()->second);
      work_.erase(work_.begin());
      work();
    }
    now_ = std::max(now_, end);
  }

  std::function<void()> between;

 private:
  using Key = std::pair<Clock::time_point, std::uint64_t>;

  class SimulatedTimer : public Timer {
   public:
    explicit SimulatedTimer(SimulatedExecutor& executor) : executor_(executor) {}
    ~SimulatedTimer() override { Cancel(); }
    void Set(Clock::time_point time, Work work) override {
      Cancel();
      key_ = executor_.Add(time, std::move(work));
    }
    void Cancel() override { executor_.work_.erase(key_); }

   private:
    SimulatedExecutor& executor_;
    Key key_;
  };

  Key Add(Clock::time_point time, Work work) {
    const Key key{time, random_()};
    work_.emplace(key, std::move(work));
    return key;
  }

  std::mt19937_64 random_;
  Clock::time_point now_;
  std::map<Key, Work> work_;
};

}  // namespace motiondb::tests
