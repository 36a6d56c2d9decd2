// Counts the calls under way, so that a server can stop taking new ones and wait for the rest, and
// break off those whose answer nobody takes. gRPC's own graceful shutdown would wait for every idle
// connection and health watch too. Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <unordered_set>
#include <utility>

#include "storage/mutex.h"

namespace motiondb::server {

class CallGate {
 public:
  using Clock = std::chrono::steady_clock;

  // A call's stay. Held by its reactor from its first moment to its last.
  class Ticket {
   public:
    // `on_close` is called when the gate closes while the call is in: for a call that would stay as
    // long as its client likes; `cancel` when it is to be broken off. Neither may wait for a call
    // to end.
    explicit Ticket(CallGate& gate, std::function<void()> on_close = {},
                    std::function<void()> cancel = {})
        : gate_(gate),
          on_close_(std::move(on_close)),
          cancel_(std::move(cancel)),
          admitted_(gate.Enter(*this)) {}
    ~Ticket() {
      if (admitted_) gate_.Leave(*this);
    }
    Ticket(const Ticket&) = delete;
    Ticket& operator=(const Ticket&) = delete;

    // False: the gate was closed, and the call is to be refused.
    bool admitted() const { return admitted_; }
    // The call has its answer; what is left is that the client takes it, for which it has `more`
    // time than others.
    void SetEnded(Clock::duration more) { ended_ = Clock::now() + more; }

   private:
    friend class CallGate;
    CallGate& gate_;
    const std::function<void()> on_close_;
    const std::function<void()> cancel_;
    std::atomic<Clock::time_point> ended_ = Clock::time_point::max();
    const bool admitted_;
  };

  // Admits nobody any more, and tells those who are in.
  void Close();
  // Returns when nobody is in, or the time has come.
  void AwaitEmpty(Clock::time_point latest);
  // Breaks off the calls that had their answer before then, and are still in.
  void CancelEndedBefore(Clock::time_point time);

 private:
  bool Enter(const Ticket& ticket);
  void Leave(const Ticket& ticket);

  storage::Mutex mutex_;
  storage::ConditionVariable empty_;
  std::unordered_set<const Ticket*> calls_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::server
