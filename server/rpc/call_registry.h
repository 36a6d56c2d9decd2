// Registry of the calls in flight. A server can refuse new calls and wait for the others, and
// cancel calls whose response is not read. gRPC's graceful shutdown would also wait for idle
// connections and health watches. Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <unordered_set>
#include <utility>

#include "storage/mutex.h"

namespace motiondb::server {

class CallRegistry {
 public:
  using Clock = std::chrono::steady_clock;

  // Registers a call for its lifetime. Member of its reactor.
  class RegisteredCall {
   public:
    // Close calls `on_close`, for calls that only their client would end. CancelEndedBefore calls
    // `cancel`. Neither may wait for the end of a call.
    explicit RegisteredCall(CallRegistry& registry, std::function<void()> on_close = {},
                            std::function<void()> cancel = {})
        : registry_(registry),
          on_close_(std::move(on_close)),
          cancel_(std::move(cancel)),
          admitted_(registry.Enter(*this)) {}
    ~RegisteredCall() {
      if (admitted_) registry_.Leave(*this);
    }
    RegisteredCall(const RegisteredCall&) = delete;
    RegisteredCall& operator=(const RegisteredCall&) = delete;

    // False: the registry was closed; refuse the call.
    bool admitted() const { return admitted_; }
    // The response is complete and only has to be read by the client, for which it has `more` time
    // in addition.
    void SetEnded(Clock::duration more) { ended_ = Clock::now() + more; }

   private:
    friend class CallRegistry;
    CallRegistry& registry_;
    const std::function<void()> on_close_;
    const std::function<void()> cancel_;
    std::atomic<Clock::time_point> ended_ = Clock::time_point::max();
    const bool admitted_;
  };

  // Refuses new calls and notifies those in flight.
  void Close();
  // Returns when no call is in flight, or at `latest`.
  void AwaitEmpty(Clock::time_point latest);
  // Cancels calls in flight that ended (SetEnded) before `time`.
  void CancelEndedBefore(Clock::time_point time);

 private:
  bool Enter(const RegisteredCall& call);
  void Leave(const RegisteredCall& call);

  storage::Mutex mutex_;
  storage::ConditionVariable empty_;
  std::unordered_set<const RegisteredCall*> calls_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::server
