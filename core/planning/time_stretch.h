// Stretches the time of a joint motion so that no joint is too fast.
#pragma once

#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/motion.h"
#include "core/motion/robot_dynamics.h"
#include "core/planning/time_law.h"

namespace motiondb::core {

// Returns limits for the coordinates of a skeleton (PoseSteps), none for its root. `dynamics`: null
// without limits of speed; its speeds are multiplied by `speed_scale`. `max_acceleration` (rad/s^2
// or m/s^2): 0: none.
RateLimits LimitRates(const Skeleton& skeleton, const RobotDynamics* dynamics, double speed_scale,
                      double max_acceleration);

// Whether any limit is finite.
bool AnyLimit(const RateLimits& limits);

struct RateViolations {
  int speeds = 0;         // number of steps between samples that are too fast
  int accelerations = 0;  // number of differences of successive steps that are too large
};

// Compares first and second differences of samples (frames x dof_count) with the limits.
RateViolations CountRateViolations(const MarkerKinematics& kinematics, const JointMotion& motion,
                                   const RateLimits& limits);

struct StretchedMotion {
  JointMotion motion;
  // Of each frame, in frames of the recorded motion.
  std::vector<double> places;
  std::vector<SlowedPart> slowed;
  double needed_seconds = 0;  // duration of the whole motion within the limits
  bool cut = false;           // it ends early, at the maximum duration
};

// Returns the motion at another frame rate, slowed where limits require it, never faster than
// recorded. All coordinates follow the same time, so poses, contacts and the path of the root stay.
// First and second differences of the samples respect the limits. The last frame is the last pose,
// unless that exceeds `max_seconds`. REQUIRES: at least 2 frames.
StretchedMotion StretchTime(const MarkerKinematics& kinematics, const JointMotion& recorded,
                            const RateLimits& limits, double frame_rate_hz, double max_seconds);

}  // namespace motiondb::core
