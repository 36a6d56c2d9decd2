// Idle timer of a call. Uses no thread while it waits. Thread-safe.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "server/engine/work/executor.h"

namespace motiondb::server {

class IdleTimer {
 public:
  // Calls `on_idle` if there is no Restart within `first`. After the first Restart or timeout
  // the interval is `longest`; the timer repeats. No call during or after destruction. `on_idle`
  // may destroy the timer.
  IdleTimer(Executor& executor, std::chrono::milliseconds first, std::chrono::milliseconds longest,
            std::function<void()> on_idle);
  ~IdleTimer();
  IdleTimer(const IdleTimer&) = delete;
  IdleTimer& operator=(const IdleTimer&) = delete;

  // Restarts the interval.
  void Restart();

 private:
  struct State;

  const std::shared_ptr<State> state_;  // shared with the executor's timer, which may fire late
};

}  // namespace motiondb::server
