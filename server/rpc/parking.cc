#include "server/rpc/parking.h"

#include <algorithm>
#include <utility>

namespace motiondb::server {

using storage::MutexLock;

struct IdleTimer::State {
  State(Executor& runs_on, std::chrono::milliseconds first, std::chrono::milliseconds further,
        std::function<void()> callback)
      : executor(runs_on),
        timer(runs_on.MakeTimer(Pool::kRequests)),
        longest(further),
        latest(runs_on.Now() + first),
        on_idle(std::move(callback)) {}

  // Sets the timer; its handler sets it again.
  static void Wait(const std::shared_ptr<State>& state)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(state->mutex) {
    state->timer->Set(state->latest, [state] {
      const MutexLock lock(state->mutex);
      if (state->ended) return;
      if (state->executor.Now() >= state->latest) {
        state->latest = state->executor.Now() + state->longest;
        state->on_idle();
        if (state->ended) return;
      }
      Wait(state);
    });
  }

  storage::RecursiveMutex mutex;  // recursive: the callback may destroy the timer
  Executor& executor;
  const std::unique_ptr<Executor::Timer> timer;
  const std::chrono::milliseconds longest;
  Executor::Clock::time_point latest ABSL_GUARDED_BY(mutex);
  const std::function<void()> on_idle;
  bool ended ABSL_GUARDED_BY(mutex) = false;
};

IdleTimer::IdleTimer(Executor& executor, std::chrono::milliseconds first,
                     std::chrono::milliseconds longest, std::function<void()> on_idle)
    : state_(std::make_shared<State>(executor, first, longest, std::move(on_idle))) {
  const MutexLock lock(state_->mutex);
  State::Wait(state_);
}

IdleTimer::~IdleTimer() {
  const MutexLock lock(state_->mutex);
  state_->ended = true;
  state_->timer->Cancel();
}

void IdleTimer::Restart() {
  // The handler compares with `latest` when it fires, so a Restart does not set the timer.
  const MutexLock lock(state_->mutex);
  state_->latest = state_->executor.Now() + state_->longest;
}

void Parking::BeginStep() {
  const MutexLock lock(mutex_);
  woken_ = false;
}

void Parking::WakeOn(ChangeSignal& signal) {
  auto& subscription = subscriptions_[&signal];
  if (subscription == nullptr) subscription = signal.Subscribe([this] { Wake(); });
}

void Parking::Park(std::chrono::system_clock::time_point latest, std::function<void()> resume) {
  using std::chrono::milliseconds;
  using std::chrono::system_clock;
  if (alarm_ == nullptr) {
    // A deadline far in the future could overflow the clock of the executor.
    const auto rest = std::clamp<system_clock::duration>(
        latest - system_clock::now(), system_clock::duration::zero(), std::chrono::hours(24));
    // Repeats, because the two clocks may differ.
    alarm_ = std::make_unique<IdleTimer>(executor_, std::chrono::ceil<milliseconds>(rest),
                                         milliseconds(1000), [this, latest] {
                                           if (system_clock::now() >= latest) Wake();
                                         });
  }
  {
    const MutexLock lock(mutex_);
    if (!woken_) {
      resume_ = std::move(resume);
      return;
    }
  }
  resume();
}

void Parking::Wake() {
  std::function<void()> resume;
  {
    const MutexLock lock(mutex_);
    woken_ = true;
    resume.swap(resume_);
  }
  if (resume) resume();
}

void Parking::Stop() {
  {
    const MutexLock lock(mutex_);
    stopped_ = true;
  }
  Wake();
}

bool Parking::stopped() const {
  const MutexLock lock(mutex_);
  return stopped_;
}

}  // namespace motiondb::server
