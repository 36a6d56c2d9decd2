// How fast the root moves, told by the markers' velocities: by all of them (section V-C, eq. 9), or
// straight by the two hips. Safe to call from any thread; the inverse is the caller's, one a
// thread.
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

// Solves v = J theta' for the velocities of all coordinates by the SR inverse, and returns those of
// the first joint. `pose` is placed and differentiated (MarkerKinematics); velocities: 1 x 3 *
// marker_count, m/s, world. Markers with NaN are left out. Takes no memory.
RootVelocity SolveRootVelocity(const MarkerKinematics& kinematics, const MarkerPose& pose,
                               const Eigen::Ref<const Eigen::RowVectorXf>& velocities,
                               SingularityRobustInverse& inverse);

// How the reference frame itself moves over the floor, seen from itself: x to the front, y to the
// left.
struct PlanarVelocity {
  double x = 0;         // leg lengths/s
  double y = 0;         // leg lengths/s
  double yaw_rate = 0;  // rad/s, anticlockwise seen from above
};

// The reference frame's velocity from the hips' in one state (1 x 6 N_v: position and velocity of
// each marker in turn, in the reference frame, in leg lengths and leg lengths/s; not scaled by a
// model), or in the mean of many. Its origin is the middle of the hips and its front is at right
// angles to the line between them, so it moves with the one and turns with the other. NaN where a
// hip is missing; no turn where one hip is straight above the other.
// REQUIRES: the set names both hips, and state.size() == set.dimension_count().
PlanarVelocity RootVelocityFromHips(const MarkerSet& set,
                                    const Eigen::Ref<const Eigen::RowVectorXf>& state);

}  // namespace motiondb::core
