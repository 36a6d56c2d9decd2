#include "server/rpc/parking.h"

#include <algorithm>
#include <utility>

namespace motiondb::server {

using storage::MutexLock;

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
                                         milliseconds(1000), [this] { Wake(); });
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
