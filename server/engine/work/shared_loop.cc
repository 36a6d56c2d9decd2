#include "server/engine/work/shared_loop.h"

#include <algorithm>
#include <atomic>
#include <memory>

#include "storage/mutex.h"

namespace motiondb::server {
namespace {

// Shared with late helpers, so it may outlive the call: they find no index left and do not use the
// body.
class SharedLoop {
 public:
  SharedLoop(int count, const std::function<void(int)>& body) : count_(count), body_(body) {}

  void Work() {
    int done = 0;
    for (int i = next_.fetch_add(1); i < count_; i = next_.fetch_add(1)) {
      try {
        const AllocationsMayFail scope;
        body_(i);
      } catch (...) {
        const storage::MutexLock lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
      }
      ++done;
    }
    if (done == 0) return;
    const storage::MutexLock lock(mutex_);
    done_ += done;
    if (done_ == count_) all_done_.NotifyAll();
  }

  void Wait() {
    std::exception_ptr failure;
    {
      const storage::MutexLock lock(mutex_);
      all_done_.Wait(mutex_, [this] {
        mutex_.AssertHeld();
        return done_ == count_;
      });
      // Moved to the caller, so that a late helper is not the last to release the exception.
      failure = std::move(failure_);
    }
    if (failure) std::rethrow_exception(failure);
  }

 private:
  const int count_;
  const std::function<void(int)>& body_;
  std::atomic<int> next_{0};
  storage::Mutex mutex_;
  storage::ConditionVariable all_done_;
  int done_ ABSL_GUARDED_BY(mutex_) = 0;
  std::exception_ptr failure_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

void RunSharedLoop(int count, const std::function<void(int)>& body, int helpers,
                   const std::function<void(std::function<void()>)>& post) {
  if (count <= 0) return;
  const auto loop = std::make_shared<SharedLoop>(count, body);
  for (int i = 0; i < std::min(helpers, count - 1); ++i) post([loop] { loop->Work(); });
  loop->Work();
  loop->Wait();
}

}  // namespace motiondb::server
