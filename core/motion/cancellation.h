// How a caller stops work that is no longer wanted.
#pragma once

#include <cstdint>
#include <functional>

namespace motiondb::core {

// True once the answer is no longer wanted (deadline passed, client gone). Asked often, from the
// calling thread; an empty function never cancels.
using Cancelled = std::function<bool()>;

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
