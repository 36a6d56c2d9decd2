// A pose on the floor: where a reference frame is and where it faces. Plain values; functions are
// safe to call from any thread.
#pragma once

#include <cmath>
#include <numbers>

namespace motiondb::core {

// Origin (m) and heading (rad, counter-clockwise about z) of a frame, in some other frame.
struct FloorPose {
  double x = 0;
  double y = 0;
  double heading = 0;
};

// `inner`, given in the frame that `outer` places, placed where `outer` is.
inline FloorPose operator*(const FloorPose& outer, const FloorPose& inner) {
  const double c = std::cos(outer.heading);
  const double s = std::sin(outer.heading);
  return {outer.x + c * inner.x - s * inner.y, outer.y + s * inner.x + c * inner.y,
          outer.heading + inner.heading};
}

// `pose` as seen from `frame`: frame * RelativeTo(frame, pose) == pose.
inline FloorPose RelativeTo(const FloorPose& frame, const FloorPose& pose) {
  const double c = std::cos(frame.heading);
  const double s = std::sin(frame.heading);
  const double dx = pose.x - frame.x;
  const double dy = pose.y - frame.y;
  return {c * dx + s * dy, -s * dx + c * dy, pose.heading - frame.heading};
}

// Angle (rad) brought to [-pi, pi].
inline double WrapAngle(double angle) {
  // Most are wrapped already, and std::remainder is slow.
  return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2 * std::numbers::pi);
}

}  // namespace motiondb::core
