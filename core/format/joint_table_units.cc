#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/format/conventions.h"
#include "core/format/joint_table.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kFullTurn_rad = 2 * std::numbers::pi;
constexpr Eigen::Index kPosedFrames = 32;

// A column of hinge angles with the hinge's limits (rad).
struct HingeColumn {
  int column = 0;
  double lower = 0;
  double upper = 0;
};

std::vector<HingeColumn> HingesWithoutUnit(const JointTableColumns& columns,
                                           const Skeleton& skeleton) {
  std::vector<const Dof*> dofs;
  for (const Joint& joint : skeleton.joints()) {
    for (const Dof& dof : joint.dofs) dofs.push_back(&dof);
  }
  std::vector<HingeColumn> limited;
  std::vector<HingeColumn> unlimited;
  for (const JointColumn& joint : columns.joints) {
    const Dof& dof = *dofs[joint.dof];
    if (joint.unit || joint.mimic != nullptr || dof.kind != Dof::Kind::kRotation) continue;
    if (std::isfinite(dof.lower) && std::isfinite(dof.upper) && dof.lower < dof.upper) {
      limited.push_back({joint.column, dof.lower, dof.upper});
    } else {
      unlimited.push_back({joint.column, -kFullTurn_rad, kFullTurn_rad});
    }
  }
  return limited.empty() ? unlimited : limited;
}

double ExcessOf(const HingeColumn& hinge, double angle_rad) {
  return std::max({0.0, hinge.lower - angle_rad, angle_rad - hinge.upper});
}

// Fraction of the frames in which the robot's own z axis is within 45 degrees of the vertical.
double UprightShare(const JointMatrix& quaternions, const std::array<int, 4>& xyzw, UpAxis up) {
  const Eigen::Vector3d vertical = WorldFromFile(up).row(2).transpose();
  Eigen::Index upright = 0;
  for (Eigen::Index frame = 0; frame < quaternions.rows(); ++frame) {
    const auto q = quaternions.row(frame);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(q[xyzw[3]], q[xyzw[0]], q[xyzw[1]], q[xyzw[2]]).normalized();
    const double cosine = vertical.dot(turn * Eigen::Vector3d::UnitZ());
    upright += cosine > std::numbers::sqrt2 / 2 ? 1 : 0;
  }
  return static_cast<double>(upright) / static_cast<double>(quaternions.rows());
}

}  // namespace

std::optional<AngleUnit> DeduceAngleUnit(const JointMatrix& values,
                                         const JointTableColumns& columns, const Skeleton& skeleton,
                                         double excess_rad) {
  constexpr double kTolerance_rad = 0.1;
  constexpr double kMinShare = 0.01;
  constexpr double kMaxShareInDegrees = 0.1;  // of the angles that exceed limits as radians
  constexpr double kMinMotion = 0.5;          // of any hinge; less says nothing
  std::int64_t all = 0;
  std::int64_t far = 0;     // beyond the limits as radians, by more than `excess_rad`
  std::int64_t beyond = 0;  // beyond the limits as radians
  std::int64_t beyond_in_degrees = 0;
  double largest = 0;
  const std::vector<HingeColumn> hinges = HingesWithoutUnit(columns, skeleton);
  for (Eigen::Index frame = 0; frame < values.rows(); ++frame) {
    for (const HingeColumn& hinge : hinges) {
      const double value = values(frame, hinge.column);
      const double excess = ExcessOf(hinge, value);
      ++all;
      far += excess > excess_rad ? 1 : 0;
      beyond += excess > kTolerance_rad ? 1 : 0;
      beyond_in_degrees += ExcessOf(hinge, value * kRadiansPerDegree) > kTolerance_rad ? 1 : 0;
      largest = std::max(largest, std::abs(value));
    }
  }
  const auto count = [](std::int64_t some) { return static_cast<double>(some); };
  if (count(far) >= std::max(1.0, kMinShare * count(all)) &&
      count(beyond_in_degrees) <= kMaxShareInDegrees * count(far)) {
    return AngleUnit::kDegrees;
  }
  if (count(beyond) < kMinShare * count(all) && largest > kMinMotion && largest <= kFullTurn_rad) {
    return AngleUnit::kRadians;
  }
  return std::nullopt;
}

std::optional<double> DeduceRootUnit(const JointMatrix& root, const JointMatrix& angles,
                                     const Skeleton& skeleton) {
  constexpr double kSole_m = 0.05;   // below the lowest joint
  constexpr double kStanding = 0.5;  // of the largest height: not lying
  constexpr double kMaxRatio = 3;    // jumps, or a floor that is not at z = 0
  const Eigen::Index count = std::min(kPosedFrames, angles.rows());
  std::vector<double> heights_m;
  std::vector<double> heights_in_file;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index frame = i * angles.rows() / count;
    const auto poses = ForwardKinematics(skeleton, angles.row(frame));
    double lowest = poses[0].translation().z();
    for (const Eigen::Isometry3d& pose : poses) lowest = std::min(lowest, pose.translation().z());
    heights_m.push_back(poses[0].translation().z() - lowest + kSole_m);
    heights_in_file.push_back(root(frame, 2));
  }
  const double tallest = *std::max_element(heights_m.begin(), heights_m.end());
  std::vector<double> ratios;
  for (std::size_t i = 0; i < heights_m.size(); ++i) {
    if (heights_m[i] >= kStanding * tallest) ratios.push_back(heights_in_file[i] / heights_m[i]);
  }
  const double ratio = Median(ratios);
  for (const double units_per_metre : {1.0, 100.0, 1000.0}) {
    if (ratio > units_per_metre / kMaxRatio && ratio < units_per_metre * kMaxRatio) {
      return 1 / units_per_metre;
    }
  }
  return std::nullopt;
}

bool IsScalarFirst(const JointMatrix& quaternions, UpAxis up) {
  constexpr double kMinUpright = 0.95;
  constexpr double kMaxUpright = 0.5;
  return UprightShare(quaternions, {1, 2, 3, 0}, up) >= kMinUpright &&
         UprightShare(quaternions, {0, 1, 2, 3}, up) < kMaxUpright;
}

}  // namespace motiondb::core
