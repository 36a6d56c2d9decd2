// Forward kinematics: joint angles to world poses of the joints, and rotations from angles.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Returns world_from_joint of every joint (m), in the skeleton's order. `angles`: one frame, 1 x
// dof_count (rad and m); a row of a JointMatrix binds without a copy. REQUIRES: angles.size() ==
// skeleton.dof_count().
std::vector<Eigen::Isometry3d> ForwardKinematics(
    const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles);

// As above, into the caller's storage; does not allocate. REQUIRES: also world_from_joint.size() ==
// skeleton.joint_count().
void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<Eigen::Isometry3d> world_from_joint);

// As above, for a subset of the joints: ascending, and with all ancestors. Leaves the other poses
// unchanged.
void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<const int> joints, std::span<Eigen::Isometry3d> world_from_joint);

// Writes the world axis of each degree of freedom at this pose: the direction of translation, or
// the axis of rotation. O(dofs), does not allocate. REQUIRES: world_from_joint is the pose at
// `angles`; axes.size() == skeleton.dof_count().
void WorldDofAxes(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                  std::span<const Eigen::Isometry3d> world_from_joint,
                  std::span<Eigen::Vector3d> axes);

// Returns the transform of one joint relative to its parent (to the world for a root). `q`: the
// joint's own degrees of freedom, joint.dofs.size() values.
Eigen::Isometry3d ParentFromJoint(const Joint& joint, std::span<const double> q);

// Returns the world positions (m) of all joints in all frames: frames x 3 * joint_count, x y z of
// each joint in turn. O(frames * joints).
FrameMatrix JointPositions(const JointMotion& motion);

// Returns the rotations from all joint frames to the world in all frames: frames x 4 * joint_count,
// the unit quaternion x y z w of each joint in turn. Of the two quaternions of a rotation, returns
// the one nearer to that of the frame before, so that values can be interpolated. O(frames *
// joints).
FrameMatrix JointRotations(const JointMotion& motion);

// Returns the angles q (rad) with R(axes[0], q[0]) R(axes[1], q[1]) R(axes[2], q[2]) = rotation. Of
// all solutions, including whole turns, returns the one nearest `previous`, so that angles are
// continuous over frames. In gimbal lock the third angle keeps its previous value. REQUIRES: axes
// have unit length and are perpendicular, in any order and handedness.
Eigen::Vector3d AnglesAboutAxes(const Eigen::Matrix3d& rotation,
                                const std::array<Eigen::Vector3d, 3>& axes,
                                const Eigen::Vector3d& previous);

// Returns the shortest rotation from one direction to another; about any perpendicular axis if they
// are opposite. Not inline: Eigen's implementation instantiates a singular value decomposition in
// every file that uses it.
Eigen::Quaterniond ShortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace motiondb::core
