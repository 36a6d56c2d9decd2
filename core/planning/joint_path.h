// A smooth path through the poses of a motion.
#pragma once

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/matrix.h"

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

}  // namespace motiondb::core
