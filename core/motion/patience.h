// Asks now and then whether work is still wanted: asking a clock costs more than a step of a tight
// loop. Used by one thread.
#pragma once

#include <cstdint>

#include "core/motion/cancellation.h"

namespace motiondb::core {

class Patience {
 public:
  // `cancelled` must outlive it.
  explicit Patience(const Cancelled& cancelled) : cancelled_(cancelled) {}

  // Counts `steps` of some nanoseconds each; asks once they have come to a millisecond or so. True
  // once the work is no longer wanted, and from then on.
  bool IsOver(std::int64_t steps) {
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
