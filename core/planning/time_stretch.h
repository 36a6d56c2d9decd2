// Stretches the time of a joint motion so that no joint is too fast, along a smooth path through
// its poses.
#pragma once

#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/matrix.h"
#include "core/motion/motion.h"
#include "core/motion/robot.h"
#include "core/planning/time_law.h"

namespace motiondb::core {

// Returns the steps between successive poses (poses x dof_count; rad and m): poses - 1 x dof_count.
// In the coordinates of MarkerKinematics: differences of angles, and for a joint with free rotation
// the rotation vector in the joint's own frame, which has no gimbal lock.
JointMatrix PoseSteps(const MarkerKinematics& kinematics, const JointMatrix& poses);

// A uniform cubic B-spline with the poses as control points, so angles are continuous up to the
// second derivative and never exceed limits that all poses respect. A pose and its two neighbours
// contribute 4/6, 1/6 and 1/6; the first and the last pose are exact. The kinematics must outlive
// the path.
class JointPath {
 public:
  // poses x dof_count; at least 2 poses.
  JointPath(const MarkerKinematics& kinematics, JointMatrix poses);

  // PoseSteps of the poses.
  const JointMatrix& steps() const { return steps_; }

  // Returns the pose (1 x dof_count) at a place on the path: 0 is the first pose, 1 the second.
  // Free rotations are unwrapped relative to `previous`. REQUIRES: place is within the path.
  Eigen::RowVectorXd At(double place, const Eigen::RowVectorXd& previous) const;

 private:
  const MarkerKinematics& kinematics_;
  JointMatrix poses_;
  JointMatrix steps_;
};

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
