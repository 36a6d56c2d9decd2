// How one thing fades into another.
#pragma once

#include <algorithm>

namespace motiondb::core {

// From 0 at share 0 to 1 at share 1 and no further, with no speed and no acceleration at either
// end, so that a blend adds no jolt.
inline double Ease(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

}  // namespace motiondb::core
