// How a caller runs long computations: when it cancels them, and on which threads their loops run.
// Core starts no threads.
#pragma once

#include <cstdint>
#include <functional>

namespace motiondb::core {

// Returns true once the work is cancelled (deadline passed, client gone). Called often, from the
// calling thread. An empty function never cancels.
using Cancelled = std::function<bool()>;

// Calls a Cancelled at a limited rate, for inner loops.
class ThrottledCancellation {
 public:
  // `cancelled` must outlive this object.
  explicit ThrottledCancellation(const Cancelled& cancelled) : cancelled_(cancelled) {}

  // Adds `steps` (a few nanoseconds each) and calls `cancelled` about once a millisecond. Returns
  // true once the work is cancelled, and from then on.
  bool cancelled(std::int64_t steps) {
    steps_ += steps;
    if (steps_ < kStepsBetween || !cancelled_) return over_;
    steps_ = 0;
    over_ = over_ || cancelled_();
    return over_;
  }

 private:
  static constexpr std::int64_t kStepsBetween = 1 << 19;

  const Cancelled& cancelled_;
  std::int64_t steps_ = 0;
  bool over_ = false;
};

// Runs body(0) ... body(count - 1), in any order and on any threads, and returns when all are done.
// Results must not depend on the order: each index writes its own result, and results are combined
// in order of index.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

// Runs on the calling thread only.
inline void RunSerially(int count, const std::function<void(int)>& body) {
  for (int i = 0; i < count; ++i) body(i);
}

}  // namespace motiondb::core
