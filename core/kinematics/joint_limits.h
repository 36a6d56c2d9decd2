// The limits of a skeleton's degrees of freedom. Plain values; safe to call from any thread.
#pragma once

#include <Eigen/Core>

#include "core/motion/motion.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// 1 x dof_count each, rad and m; infinite where there is no limit.
struct JointLimits {
  Eigen::RowVectorXd lower;
  Eigen::RowVectorXd upper;
};

JointLimits LimitsOf(const Skeleton& skeleton);
// Limits that nothing oversteps.
JointLimits NoLimits(const Skeleton& skeleton);

// The number of angles (one a frame and degree of freedom) that are beyond the skeleton's own
// limits by more than `tolerance` (rad or m), or not finite.
int CountLimitViolations(const JointMotion& motion, double tolerance);

}  // namespace motiondb::core
