// Lets a call wait without a thread: for its client, or for a change.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>

#include "server/engine/change_signal.h"
#include "server/engine/work/executor.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Idle timer of a call. Uses no thread while it waits. Thread-safe.
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

// Lets a call wait for a change, as of a database, without a thread. A step of the call that cannot
// go on subscribes to the changes and returns AwaitsChange(); the reactor then parks the call.
// A call that never parks makes no timer.
class Parking {
 public:
  explicit Parking(Executor& executor) : executor_(executor) {}

  // The following three are called by the steps of the call, by one thread at a time.

  // Forgets earlier wakes. Call before each step.
  void BeginStep();
  // From now on each change wakes the call. Has an effect only once for each signal, which must
  // live as long as the call uses it.
  void WakeOn(ChangeSignal& signal);
  // Calls `resume` once, on any thread: when woken since BeginStep, or soon after `latest`, which
  // is the same for all steps. It must not block.
  void Park(std::chrono::system_clock::time_point latest, std::function<void()> resume);

  void Wake();
  // Wakes; the call ends instead of parking again.
  void Stop();
  bool stopped() const;

 private:
  Executor& executor_;
  mutable storage::Mutex mutex_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::function<void()> resume_ ABSL_GUARDED_BY(mutex_);
  // Last: their callbacks use the members above.
  std::unique_ptr<IdleTimer> alarm_;  // null: never parked
  std::map<const ChangeSignal*, std::unique_ptr<ChangeSignal::Subscription>> subscriptions_;
};

}  // namespace motiondb::server
