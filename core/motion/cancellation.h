// Cooperative cancellation.
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

}  // namespace motiondb::core
