#include "core/motion/floor_origin.h"

#include <cmath>
#include <variant>

#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

// A missing or implausible position says nothing about the other frames.
bool IsInWorld(const Eigen::Vector2d& position) { return (position.array().abs() <= 1e5).all(); }

Eigen::Vector2d FirstPosition(const Motion& motion) {
  if (const auto* joints = std::get_if<JointMotion>(&motion)) {
    const Joint& root = joints->skeleton->joints().front();
    for (Eigen::Index t = 0; t < joints->angles.rows(); ++t) {
      const std::span<const double> q(joints->angles.row(t).data(), root.dofs.size());
      const Eigen::Vector2d position = ParentFromJoint(root, q).translation().head<2>();
      if (IsInWorld(position)) return position;
    }
    return Eigen::Vector2d::Zero();
  }
  const FrameMatrix& positions = std::get<MarkerMotion>(motion).positions_m;
  for (Eigen::Index i = 0; i + 2 < positions.size(); i += 3) {
    const Eigen::Vector2d position(positions.data()[i], positions.data()[i + 1]);
    if (IsInWorld(position)) return position;
  }
  return Eigen::Vector2d::Zero();
}

}  // namespace

Eigen::Vector2d NearestCorner(const Eigen::Vector2d& point) {
  constexpr double kGrid_m = 16;
  if (!point.allFinite()) return Eigen::Vector2d::Zero();
  return kGrid_m * (point / kGrid_m).array().round().matrix();
}

Eigen::Vector2d FloorOrigin(const Motion& motion) { return NearestCorner(FirstPosition(motion)); }

}  // namespace motiondb::core
