#include "server/rpc/parking.h"

#include <algorithm>
#include <utility>

namespace motiondb::server {

using storage::MutexLock;

struct Parking::Alarm {
  storage::Mutex mutex;
  Parking* parking ABSL_GUARDED_BY(mutex) = nullptr;  // null: the call has ended
  std::unique_ptr<Executor::Timer> timer ABSL_GUARDED_BY(mutex);
};

Parking::Parking(Executor& executor) : alarm_(std::make_shared<Alarm>()) {
  const MutexLock lock(alarm_->mutex);
  alarm_->parking = this;
  alarm_->timer = executor.MakeTimer(Pool::kRequests);
}

Parking::~Parking() {
  subscription_.reset();
  std::unique_ptr<Executor::Timer> timer;
  const MutexLock lock(alarm_->mutex);
  alarm_->parking = nullptr;
  timer.swap(alarm_->timer);
}

void Parking::BeginStep() {
  const MutexLock lock(mutex_);
  woken_ = false;
}

void Parking::WakeOn(ChangeSignal& signal) {
  if (subscription_ == nullptr) subscription_ = signal.Subscribe([this] { Wake(); });
}

void Parking::Park(std::chrono::system_clock::time_point latest, std::function<void()> resume) {
  using std::chrono::system_clock;
  // A deadline far in the future has no use, and could overflow the clock of the executor.
  constexpr auto kLongest = std::chrono::hours(24);
  const auto rest = std::clamp<system_clock::duration>(latest - system_clock::now(),
                                                       system_clock::duration::zero(), kLongest);
  {
    const MutexLock lock(alarm_->mutex);
    alarm_->timer->Set(Executor::Clock::now() + rest, [alarm = alarm_] {
      const MutexLock alarm_lock(alarm->mutex);
      if (alarm->parking != nullptr) alarm->parking->Wake();
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
