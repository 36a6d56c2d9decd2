#include "server/rpc/silence_limit.h"

#include <boost/asio/steady_timer.hpp>
#include <mutex>
#include <utility>

namespace motiondb::server {

using Clock = std::chrono::steady_clock;

struct SilenceLimit::State {
  State(const Workers::Executor& executor, std::chrono::milliseconds first,
        std::chrono::milliseconds further, std::function<void()> to_tell)
      : timer(executor),
        longest(further),
        latest(Clock::now() + first),
        on_silence(std::move(to_tell)) {}

  std::recursive_mutex mutex;  // who is told may destroy the limit
  boost::asio::steady_timer timer;
  const std::chrono::milliseconds longest;
  Clock::time_point latest;
  const std::function<void()> on_silence;
  bool over = false;
};

SilenceLimit::SilenceLimit(const Workers::Executor& executor, std::chrono::milliseconds first,
                           std::chrono::milliseconds longest, std::function<void()> on_silence)
    : state_(std::make_shared<State>(executor, first, longest, std::move(on_silence))) {
  const std::lock_guard lock(state_->mutex);
  Wait(state_);
}

SilenceLimit::~SilenceLimit() {
  const std::lock_guard lock(state_->mutex);
  state_->over = true;
  state_->timer.cancel();
}

void SilenceLimit::Restart() {
  // The timer looks when it fires, so that a message costs no timer.
  const std::lock_guard lock(state_->mutex);
  state_->latest = Clock::now() + state_->longest;
}

// REQUIRES: the state's mutex is held.
void SilenceLimit::Wait(const std::shared_ptr<State>& state) {
  state->timer.expires_at(state->latest);
  state->timer.async_wait([state](const boost::system::error_code&) {
    const std::lock_guard lock(state->mutex);
    if (state->over) return;
    if (Clock::now() >= state->latest) {
      state->latest = Clock::now() + state->longest;
      state->on_silence();
      if (state->over) return;
    }
    Wait(state);
  });
}

}  // namespace motiondb::server
