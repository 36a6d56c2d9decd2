// Velocity of the root from the markers' velocities: from all markers (section V-C, eq. 9), or from
// the hips alone.
#pragma once

#include <Eigen/Core>

#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/singularity_robust.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

struct RootVelocity {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // of the root joint's origin, m/s, world
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // rad/s, world
};

// Solves v = J theta' for all velocity coordinates with the SR inverse, and returns the first
// joint's. `pose`: placed and differentiated (MarkerKinematics). velocities: 1 x 3 * marker_count,
// m/s, world; NaN is ignored. Does not allocate.
RootVelocity SolveRootVelocity(const MarkerKinematics& kinematics, const MarkerPose& pose,
                               const Eigen::Ref<const Eigen::RowVectorXf>& velocities,
                               SingularityRobustInverse& inverse);

// Velocity of the reference frame on the floor, in its own axes: x to the front, y to the left.
struct PlanarVelocity {
  double x = 0;         // leg lengths/s
  double y = 0;         // leg lengths/s
  double yaw_rate = 0;  // rad/s, anticlockwise seen from above
};

// Returns the reference frame's velocity from the hips in one state (1 x 6 N_v, in leg lengths and
// leg lengths/s, not scaled by a model) or in a mean of states. The origin is the middle of the
// hips and the front is perpendicular to the hip line, so they move and turn with the hips. NaN if
// a hip is missing; no rotation if one hip is exactly above the other. REQUIRES: the set has both
// hips, and state.size() == set.dimension_count().
PlanarVelocity RootVelocityFromHips(const MarkerSet& set,
                                    const Eigen::Ref<const Eigen::RowVectorXf>& state);

}  // namespace motiondb::core
