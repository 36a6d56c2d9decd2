// Work on several threads that is given up when nobody wants it any more. Thread-safe.
#pragma once

#include <exception>
#include <functional>
#include <utility>

#include "core/motion/cancellation.h"
#include "core/tree/parallel.h"

namespace motiondb::server {

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
