// Counts the calls under way, so that a server can stop taking new ones and wait for the rest.
// gRPC's own graceful shutdown would wait for every idle connection and health watch too.
// Thread-safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace motiondb::server {

class CallGate {
 public:
  // A call's stay. Held by its reactor from its first moment to its last.
  class Ticket {
   public:
    explicit Ticket(CallGate& gate) : gate_(gate), admitted_(gate.Enter()) {}
    ~Ticket() {
      if (admitted_) gate_.Leave();
    }
    Ticket(const Ticket&) = delete;
    Ticket& operator=(const Ticket&) = delete;

    // False: the gate was closed, and the call is to be refused.
    bool admitted() const { return admitted_; }

   private:
    CallGate& gate_;
    const bool admitted_;
  };

  // Admits nobody any more.
  void Close();
  // Returns when nobody is in, or the time has come.
  void AwaitEmpty(std::chrono::steady_clock::time_point latest);

 private:
  bool Enter();
  void Leave();

  std::mutex mutex_;
  std::condition_variable empty_;
  int calls_ = 0;
  bool closed_ = false;
};

}  // namespace motiondb::server
