// Forces and torques that a motion needs: Newton's and Euler's equations for the links of a robot
// (recursive Newton-Euler algorithm on sampled motion).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "core/motion/motion.h"
#include "core/motion/robot.h"

namespace motiondb::core {

// A force (N) and its moment about the world's origin (N m), along the world's axes.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();

  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    moment += other.moment;
    return *this;
  }
  Wrench& operator-=(const Wrench& other) {
    force -= other.force;
    moment -= other.moment;
    return *this;
  }
};

// World poses of all joints in one frame.
using JointPoses = std::vector<Eigen::Isometry3d>;

// Returns the wrench on each link, besides gravity (9.81 m/s^2 along -z), that causes its motion in
// the frame `at`. Velocities and accelerations are central differences with the frames before and
// after, 1 / rate_hz seconds away; their errors decrease with the square of the rate. `links`: of
// each joint. O(joints).
std::vector<Wrench> LinkWrenches(std::span<const LinkInertia> links, const JointPoses& before,
                                 const JointPoses& at, const JointPoses& after, double rate_hz);

// Returns the effort (1 x dof_count; N m, or N of a translation) of each degree of freedom that
// exerts the wrenches of the links that it moves. Subtract the wrenches of contacts from those of
// their links first. With all contacts, the efforts of a floating base are 0. O(joints).
Eigen::RowVectorXd JointEfforts(const Skeleton& skeleton,
                                const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                                const JointPoses& poses, std::vector<Wrench> wrenches);

}  // namespace motiondb::core
