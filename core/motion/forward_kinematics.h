// Forward kinematics: joint angles -> where every joint is in the world.
// The functions keep no state and are safe to call from any thread.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/motion/motion.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// One frame: angles (1 x dof_count, rad and m) -> world_from_joint of each joint (m), in the
// skeleton's order. A row of a JointMatrix binds without a copy.
// REQUIRES: angles.size() == skeleton.dof_count().
std::vector<Eigen::Isometry3d> ForwardKinematics(
    const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles);

// The same into the caller's storage, for loops over frames: takes no memory.
// REQUIRES: also world_from_joint.size() == skeleton.joint_count().
void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<Eigen::Isometry3d> world_from_joint);

// The same for some of the joints, numbered in ascending order and with them all that they hang
// from; the others' poses are left as they are.
void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<const int> joints, std::span<Eigen::Isometry3d> world_from_joint);

// The axis of each degree of freedom in the world, as the pose has it: what a unit of its speed
// moves along or turns about. O(dofs), takes no memory. REQUIRES: world_from_joint is that pose;
// axes.size() == skeleton.dof_count().
void WorldDofAxes(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                  std::span<const Eigen::Isometry3d> world_from_joint,
                  std::span<Eigen::Vector3d> axes);

// The transform of one joint relative to its parent (to the world for a root). `q` holds the
// joint's own degrees of freedom, as many as joint.dofs.
Eigen::Isometry3d ParentFromJoint(const Joint& joint, std::span<const double> q);

// World positions (m) of all joints over all frames: frames x 3 * joint_count, x y z of each joint
// in turn. O(frames * joints).
FrameMatrix JointPositions(const JointMotion& motion);

// Rotations from angles and vectors. Safe to call from any thread.

// The angles q (rad) with R(axes[0], q[0]) R(axes[1], q[1]) R(axes[2], q[2]) = rotation. Of the two
// ways to write a rotation, and of all whole turns, those nearest `previous`, so that angles run on
// over the frames of a motion. Where the second turn brings the third axis onto the first (gimbal
// lock), the third angle stays as it was.
// REQUIRES: axes are of unit length and at right angles to each other, in any order and handedness.
Eigen::Vector3d AnglesAboutAxes(const Eigen::Matrix3d& rotation,
                                const std::array<Eigen::Vector3d, 3>& axes,
                                const Eigen::Vector3d& previous);

// The shortest turn from one direction to another; about any axis where they are opposite. Not
// inline: Eigen's own brings a singular value decomposition into every file that uses it.
Eigen::Quaterniond ShortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace motiondb::core
