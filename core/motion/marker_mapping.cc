#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/marker_rules.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

std::vector<std::string> PointNames(const Motion& motion) {
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) return markers->names;
  return JointNames(*std::get<JointMotion>(motion).skeleton);
}

FrameMatrix WeightedSums(const std::vector<BoundRule>& rules, const FrameMatrix& points) {
  FrameMatrix sums = FrameMatrix::Zero(points.rows(), static_cast<Eigen::Index>(3 * rules.size()));
  for (std::size_t m = 0; m < rules.size(); ++m) {
    for (const auto& [point, weight] : rules[m].points) {
      sums.middleCols<3>(static_cast<Eigen::Index>(3 * m)) +=
          static_cast<float>(weight) * points.middleCols<3>(3 * point);
    }
  }
  return sums;
}

// Adds the offsets, which turn with their links.
void AddOffsets(const std::vector<BoundRule>& rules, const JointMotion& motion, double leg_length_m,
                FrameMatrix& positions) {
  std::vector<Eigen::Isometry3d> world_from_joint(motion.skeleton->joint_count());
  for (Eigen::Index t = 0; t < positions.rows(); ++t) {
    ForwardKinematics(*motion.skeleton, motion.angles.row(t), world_from_joint);
    for (std::size_t m = 0; m < rules.size(); ++m) {
      if (rules[m].offset_joint < 0) continue;
      const Eigen::Vector3d offset =
          leg_length_m * (world_from_joint[rules[m].offset_joint].linear() * rules[m].offset);
      positions.row(t).segment<3>(static_cast<Eigen::Index>(3 * m)) +=
          offset.cast<float>().transpose();
    }
  }
}

}  // namespace

absl::StatusOr<MarkerScheme> SourceScheme(const Motion& motion) {
  MarkerScheme scheme;
  scheme.set.name = "source";
  for (const std::string& name : PointNames(motion)) {
    const bool end_site = std::holds_alternative<JointMotion>(motion) && name.ends_with("_end");
    if (!end_site) scheme.set.markers.push_back(name);
  }
  scheme.set.landmarks = RecognizeLandmarks(scheme.set.markers);
  if (scheme.set.landmarks.left_hip < 0 || scheme.set.landmarks.right_hip < 0) {
    return InvalidArgument(
        "no left and right hip among the {} names ('{}', ...), so root and front are unknown: name "
        "them in a marker-set file",
        scheme.set.markers.size(), scheme.set.markers.empty() ? "" : scheme.set.markers.front());
  }
  return scheme;
}

absl::StatusOr<MarkerMotion> ApplyScheme(const MarkerScheme& scheme, const Motion& motion,
                                         std::optional<double> leg_length_m) {
  MOTIONDB_ASSIGN_OR_RETURN(const BoundMapping mapping, BindMapping(scheme, PointNames(motion)));

  MarkerMotion mapped;
  mapped.names = scheme.set.markers;
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) {
    if (mapping.has_offsets) {
      return InvalidArgument("mapping '{}' has offsets in link frames, which bare markers lack",
                             mapping.name);
    }
    mapped.frame_rate_hz = markers->frame_rate_hz;
    mapped.positions_m = WeightedSums(mapping.rules, markers->positions_m);
    return mapped;
  }
  const JointMotion& joints = std::get<JointMotion>(motion);
  mapped.frame_rate_hz = joints.frame_rate_hz;
  mapped.positions_m = WeightedSums(mapping.rules, JointPositions(joints));
  if (mapping.has_offsets) {
    if (!leg_length_m) {
      MOTIONDB_ASSIGN_OR_RETURN(leg_length_m, EstimateLegLength(scheme.set, mapped));
    }
    AddOffsets(mapping.rules, joints, *leg_length_m, mapped.positions_m);
  }
  return mapped;
}

}  // namespace motiondb::core
