// Tells a reactor that its client has kept it waiting for too long. Holds no thread meanwhile.
// Thread-safe.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "server/engine/executor.h"

namespace motiondb::server {

class SilenceLimit {
 public:
  // Calls `on_silence` when `first` has passed without a Restart, and from then on each time that
  // `longest` has since the last one; not while or after the limit is destroyed, which it may do
  // itself.
  SilenceLimit(Executor& executor, std::chrono::milliseconds first,
               std::chrono::milliseconds longest, std::function<void()> on_silence);
  ~SilenceLimit();
  SilenceLimit(const SilenceLimit&) = delete;
  SilenceLimit& operator=(const SilenceLimit&) = delete;

  // The client has its time anew.
  void Restart();

 private:
  struct State;

  const std::shared_ptr<State> state_;  // shared with the timer, which may fire late
};

}  // namespace motiondb::server
