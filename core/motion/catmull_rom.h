// Between the frames of a motion. Pure; safe to call from any thread.
#pragma once

#include <cmath>

namespace motiondb::core {

// Between b and c, a share `u` of the way: Catmull-Rom, linear where an outer point is missing.
inline float CatmullRom(float a, float b, float c, float d, float u) {
  const float cubic =
      b + 0.5F * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
  return std::isnan(cubic) ? b + u * (c - b) : cubic;
}

}  // namespace motiondb::core
