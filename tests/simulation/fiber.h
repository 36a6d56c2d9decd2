// Functions that can pause: each has a stack of its own, and all run on one thread. POSIX contexts,
// which are part of the C library; Boost.Context would be one more package for two functions.
#pragma once

#include <ucontext.h>

#include <functional>

namespace motiondb::simulation {

class Fiber {
 public:
  explicit Fiber(std::function<void()> body);
  // REQUIRES: the body has ended or never began.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  // Runs the body until it pauses or ends. REQUIRES: called outside of fibers; it has not ended.
  void Resume();
  // Returns to Resume. REQUIRES: called by the body.
  void Pause();
  bool has_ended() const { return has_ended_; }

 private:
  static void Main();

  std::function<void()> body_;
  void* const stack_;
  ucontext_t inside_{};
  ucontext_t outside_{};
  bool has_ended_ = false;
};

}  // namespace motiondb::simulation
