#include "server/rpc/silence_limit.h"

#include <mutex>
#include <utility>

namespace motiondb::server {

struct SilenceLimit::State {
  State(Executor& runs_on, std::chrono::milliseconds first, std::chrono::milliseconds further,
        std::function<void()> to_tell)
      : executor(runs_on),
        timer(runs_on.MakeTimer(Pool::kRequests)),
        longest(further),
        latest(runs_on.Now() + first),
        on_silence(std::move(to_tell)) {}

  std::recursive_mutex mutex;  // who is told may destroy the limit
  Executor& executor;
  const std::unique_ptr<Executor::Timer> timer;
  const std::chrono::milliseconds longest;
  Executor::Clock::time_point latest;
  const std::function<void()> on_silence;
  bool over = false;
};

SilenceLimit::SilenceLimit(Executor& executor, std::chrono::milliseconds first,
                           std::chrono::milliseconds longest, std::function<void()> on_silence)
    : state_(std::make_shared<State>(executor, first, longest, std::move(on_silence))) {
  const std::lock_guard lock(state_->mutex);
  Wait(state_);
}

SilenceLimit::~SilenceLimit() {
  const std::lock_guard lock(state_->mutex);
  state_->over = true;
  state_->timer->Cancel();
}

void SilenceLimit::Restart() {
  // The timer looks when it fires, so that a message costs no timer.
  const std::lock_guard lock(state_->mutex);
  state_->latest = state_->executor.Now() + state_->longest;
}

// REQUIRES: the state's mutex is held.
void SilenceLimit::Wait(const std::shared_ptr<State>& state) {
  state->timer->Set(state->latest, [state] {
    const std::lock_guard lock(state->mutex);
    if (state->over) return;
    if (state->executor.Now() >= state->latest) {
      state->latest = state->executor.Now() + state->longest;
      state->on_silence();
      if (state->over) return;
    }
    Wait(state);
  });
}

}  // namespace motiondb::server
