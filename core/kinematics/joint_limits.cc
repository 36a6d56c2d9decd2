#include "core/kinematics/joint_limits.h"

#include <limits>

namespace motiondb::core {

JointLimits LimitsOf(const Skeleton& skeleton) {
  JointLimits limits = NoLimits(skeleton);
  Eigen::Index column = 0;
  for (const Joint& joint : skeleton.joints()) {
    for (const Dof& dof : joint.dofs) {
      limits.lower[column] = dof.lower;
      limits.upper[column++] = dof.upper;
    }
  }
  return limits;
}

JointLimits NoLimits(const Skeleton& skeleton) {
  const auto infinite =
      Eigen::RowVectorXd::Constant(skeleton.dof_count(), std::numeric_limits<double>::infinity());
  return {-infinite, infinite};
}

int CountLimitViolations(const JointMotion& motion, double tolerance) {
  const JointLimits limits = LimitsOf(*motion.skeleton);
  Eigen::Index count = 0;
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const auto angles = motion.angles.row(frame).array();
    const auto within = angles >= limits.lower.array() - tolerance &&
                        angles <= limits.upper.array() + tolerance && angles.isFinite();
    count += angles.size() - within.count();
  }
  return static_cast<int>(count);
}

}  // namespace motiondb::core
