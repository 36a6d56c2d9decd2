#include "core/motion/motion_floor.h"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "core/motion/forward_kinematics.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kAnkleHeight = 0.08;   // leg lengths
constexpr double kStandingSpeed = 0.8;  // leg lengths per second
constexpr double kMinStanding_s = 0.1;
constexpr double kHalfSpan_s = 0.02;  // of the differences: noise of markers is no movement
constexpr double kMaxLevel = 0.15;    // leg lengths

}  // namespace

std::optional<double> FloorLevel(const MarkerSet& set, const MarkerMotion& motion,
                                 double leg_length_m) {
  const auto span = std::max<Eigen::Index>(1, std::lround(kHalfSpan_s * motion.frame_rate_hz));
  const double seconds = 2 * static_cast<double>(span) / motion.frame_rate_hz;
  const double longest_step_m = kStandingSpeed * leg_length_m * seconds;
  std::vector<float> heights;
  for (const auto& leg : set.landmarks.legs) {
    const auto ankle = motion.positions_m.middleCols<3>(3 * leg[2]);
    for (Eigen::Index t = span; t + span < ankle.rows(); ++t) {
      const double step_m = (ankle.row(t + span) - ankle.row(t - span)).norm();
      if (step_m < longest_step_m && std::isfinite(ankle(t, 2))) heights.push_back(ankle(t, 2));
    }
  }
  if (static_cast<double>(heights.size()) < kMinStanding_s * motion.frame_rate_hz) return {};
  const double level_m = Median(heights) - kAnkleHeight * leg_length_m;
  if (std::abs(level_m) > kMaxLevel * leg_length_m) return {};
  return level_m;
}

double MoveToFloor(const MarkerSet& set, double leg_length_m, MarkerMotion& motion) {
  const double level_m = FloorLevel(set, motion, leg_length_m).value_or(0);
  for (Eigen::Index z = 2; z < motion.positions_m.cols(); z += 3) {
    motion.positions_m.col(z).array() -= static_cast<float>(level_m);
  }
  return level_m;
}

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
