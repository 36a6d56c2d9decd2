// A loop that several threads of a pool share, and work on several threads that is given up when
// nobody wants it any more. Thread-safe.
#pragma once

#include <exception>
#include <functional>
#include <utility>

#include "core/motion/cancellation.h"
#include "core/tree/parallel.h"

namespace motiondb::server {

// Runs body(0) ... body(count - 1) on the calling thread and on up to `helpers` others, to which
// `post` hands a piece of work; returns when all are done. Free of deadlock: a helper that comes
// late, or never, leaves the work to the others. The first exception of a body is thrown here,
// after the rest have ended.
void RunSharedLoop(int count, const std::function<void(int)>& body, int helpers,
                   const std::function<void(std::function<void()>)>& post);

// Thrown to where the work was begun.
class WorkStopped : public std::exception {
 public:
  const char* what() const noexcept override { return "the work was stopped"; }
};

// `parallel` that, once `stopped`, begins no more bodies, and throws WorkStopped when those that
// had begun have ended: whatever is under way is left within one body's time. `stopped` is asked
// from all threads.
inline core::ParallelFor Stoppable(core::ParallelFor parallel, core::Cancelled stopped) {
  return [parallel = std::move(parallel), stopped = std::move(stopped)](
             int count, const std::function<void(int)>& body) {
    parallel(count, [&](int i) {
      if (!stopped()) body(i);
    });
    if (stopped()) throw WorkStopped();
  };
}

}  // namespace motiondb::server
