#include "core/motion/rotation_angles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace motiondb::core {
namespace {

// Below this cosine of the second angle the first and the third cannot be told apart.
constexpr double kLock = 1e-9;

double NearestTurn(double angle, double previous) {
  return previous + std::remainder(angle - previous, 2 * std::numbers::pi);
}

// m = Rx(q0) Ry(q1) Rz(q2) with q2 known.
Eigen::Vector3d WithThird(const Eigen::Matrix3d& m, double third, const Eigen::Vector3d& previous) {
  const Eigen::Matrix3d rest = m * Eigen::AngleAxisd(-third, Eigen::Vector3d::UnitZ());
  return {NearestTurn(std::atan2(rest(2, 1), rest(1, 1)), previous[0]),
          NearestTurn(std::atan2(rest(0, 2), rest(0, 0)), previous[1]),
          NearestTurn(third, previous[2])};
}

}  // namespace

Eigen::Vector3d AnglesAboutAxes(const Eigen::Matrix3d& rotation,
                                const std::array<Eigen::Vector3d, 3>& axes,
                                const Eigen::Vector3d& previous) {
  // In the axes as a right-handed frame the rotation is Rx Ry Rz; a third axis that points the
  // other way has the opposite angle.
  const double hand = axes[0].cross(axes[1]).dot(axes[2]) < 0 ? -1 : 1;
  Eigen::Matrix3d frame;
  frame << axes[0], axes[1], hand * axes[2];
  const Eigen::Matrix3d m = frame.transpose() * rotation * frame;
  const Eigen::Vector3d before(previous[0], previous[1], hand * previous[2]);

  Eigen::Vector3d angles;
  if (std::hypot(m(0, 0), m(0, 1)) < kLock) {
    angles = WithThird(m, before[2], before);
  } else {
    const double third = std::atan2(-m(0, 1), m(0, 0));
    angles = WithThird(m, third, before);
    const Eigen::Vector3d other = WithThird(m, third + std::numbers::pi, before);
    if ((other - before).squaredNorm() < (angles - before).squaredNorm()) angles = other;
  }
  angles[2] *= hand;
  return angles;
}

}  // namespace motiondb::core
