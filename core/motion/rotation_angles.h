// A rotation matrix -> angles about three given axes. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <array>

namespace motiondb::core {

// The angles q (rad) with R(axes[0], q[0]) R(axes[1], q[1]) R(axes[2], q[2]) = rotation. Of the two
// ways to write a rotation, and of all whole turns, those nearest `previous`, so that angles run on
// over the frames of a motion. Where the second turn brings the third axis onto the first (gimbal
// lock), the third angle stays as it was.
// REQUIRES: axes are of unit length and at right angles to each other, in any order and handedness.
Eigen::Vector3d AnglesAboutAxes(const Eigen::Matrix3d& rotation,
                                const std::array<Eigen::Vector3d, 3>& axes,
                                const Eigen::Vector3d& previous);

}  // namespace motiondb::core
