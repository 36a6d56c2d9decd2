// Lets a call wait for a change of a database without a thread. A step of the call that cannot go
// on subscribes to the changes and returns AwaitsChange(); the reactor then parks the call.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "server/engine/change_signal.h"
#include "server/engine/executor.h"
#include "storage/mutex.h"

namespace motiondb::server {

class Parking {
 public:
  explicit Parking(Executor& executor);
  ~Parking();

  // The following three are called by the steps of the call, by one thread at a time.

  // Forgets earlier wakes. Call before each step.
  void BeginStep();
  // From now on each change wakes the call. Has an effect only once.
  void WakeOn(ChangeSignal& signal);
  // Calls `resume` once, on any thread: when woken since BeginStep, at the latest at `latest`. It
  // must not block.
  void Park(std::chrono::system_clock::time_point latest, std::function<void()> resume);

  void Wake();
  // Wakes; the call ends instead of parking again.
  void Stop();
  bool stopped() const;

 private:
  mutable storage::Mutex mutex_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::function<void()> resume_ ABSL_GUARDED_BY(mutex_);
  struct Alarm;
  const std::shared_ptr<Alarm> alarm_;  // shared with the executor's timer, which may fire late
  std::unique_ptr<ChangeSignal::Subscription> subscription_;  // first to be destroyed
};

}  // namespace motiondb::server
