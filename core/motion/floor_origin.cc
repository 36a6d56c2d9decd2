#include "core/motion/floor_origin.h"

#include <cmath>
#include <variant>

#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

Eigen::Vector2d FirstPlace(const Motion& motion) {
  if (const auto* joints = std::get_if<JointMotion>(&motion)) {
    if (joints->angles.rows() == 0) return Eigen::Vector2d::Zero();
    const Joint& root = joints->skeleton->joints().front();
    const std::span<const double> q(joints->angles.data(), root.dofs.size());
    return ParentFromJoint(root, q).translation().head<2>();
  }
  const FrameMatrix& positions = std::get<MarkerMotion>(motion).positions_m;
  for (Eigen::Index i = 0; i + 2 < positions.size(); i += 3) {
    const Eigen::Vector2d place(positions.data()[i], positions.data()[i + 1]);
    if (place.allFinite()) return place;
  }
  return Eigen::Vector2d::Zero();
}

}  // namespace

Eigen::Vector2d NearestCorner(const Eigen::Vector2d& point) {
  constexpr double kGrid_m = 16;
  if (!point.allFinite()) return Eigen::Vector2d::Zero();
  return kGrid_m * (point / kGrid_m).array().round().matrix();
}

Eigen::Vector2d FloorOrigin(const Motion& motion) { return NearestCorner(FirstPlace(motion)); }

}  // namespace motiondb::core
