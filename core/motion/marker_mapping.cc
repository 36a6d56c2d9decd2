#include <limits>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/floor_origin.h"
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

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

// Returns the weighted sums (weights sum to 1), relative to `origin`.
FrameMatrix WeightedSums(const std::vector<BoundRule>& rules, const FrameMatrix& points,
                         const Eigen::Vector2d& origin) {
  const Eigen::RowVector3f from = Eigen::RowVector2f(origin.cast<float>().transpose())
                                      .homogeneous()
                                      .cwiseProduct(Eigen::RowVector3f(1, 1, 0));
  FrameMatrix sums = FrameMatrix::Zero(points.rows(), static_cast<Eigen::Index>(3 * rules.size()));
  for (std::size_t m = 0; m < rules.size(); ++m) {
    if (rules[m].points.empty()) {
      sums.middleCols<3>(static_cast<Eigen::Index>(3 * m)).setConstant(kMissing);
    }
    for (const auto& [point, weight] : rules[m].points) {
      sums.middleCols<3>(static_cast<Eigen::Index>(3 * m)) +=
          static_cast<float>(weight) * (points.middleCols<3>(3 * point).rowwise() - from);
    }
  }
  return sums;
}

// Returns the joints that the rules use, and their ancestors, in the skeleton's order.
std::vector<int> NeededJoints(const std::vector<BoundRule>& rules, const Skeleton& skeleton) {
  std::vector<bool> is_needed(skeleton.joint_count(), false);
  const auto need = [&](int joint) {
    for (; joint >= 0 && !is_needed[joint]; joint = skeleton.joints()[joint].parent) {
      is_needed[joint] = true;
    }
  };
  for (const BoundRule& rule : rules) {
    for (const auto& [joint, weight] : rule.points) need(joint);
    need(rule.offset_joint);
  }
  std::vector<int> needed;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    if (is_needed[j]) needed.push_back(j);
  }
  return needed;
}

// A few milliseconds for the largest skeletons.
constexpr Eigen::Index kFramesBetweenChecks = 256;

// Matrices of frames x 3 * rules.
struct JointMarkers {
  FrameMatrix positions_m;  // without the offsets
  JointMatrix offsets;      // rotated to the world, leg lengths; no rows if no rule has an offset
};

absl::StatusOr<JointMarkers> MarkersOfJoints(const BoundMapping& mapping, const JointMotion& motion,
                                             const Eigen::Vector2d& origin,
                                             const Cancelled& cancelled) {
  const Eigen::Vector3d from(origin.x(), origin.y(), 0);
  const std::vector<BoundRule>& rules = mapping.rules;
  const std::vector<int> needed = NeededJoints(rules, *motion.skeleton);
  std::vector<Eigen::Isometry3d> world_from_joint(motion.skeleton->joint_count());
  const Eigen::Index frames = motion.angles.rows();
  const auto numbers = static_cast<Eigen::Index>(3 * rules.size());
  JointMarkers markers{FrameMatrix::Zero(frames, numbers),
                       JointMatrix::Zero(mapping.has_offsets ? frames : 0, numbers)};
  for (Eigen::Index t = 0; t < frames; ++t) {
    if (t % kFramesBetweenChecks == 0 && cancelled && cancelled()) {
      return absl::CancelledError("the mapping was cancelled");
    }
    ForwardKinematics(*motion.skeleton, motion.angles.row(t), needed, world_from_joint);
    for (std::size_t m = 0; m < rules.size(); ++m) {
      const auto at = static_cast<Eigen::Index>(3 * m);
      if (rules[m].points.empty()) markers.positions_m.row(t).segment<3>(at).setConstant(kMissing);
      for (const auto& [joint, weight] : rules[m].points) {
        markers.positions_m.row(t).segment<3>(at) +=
            static_cast<float>(weight) *
            (world_from_joint[joint].translation() - from).transpose().cast<float>();
      }
      if (rules[m].offset_joint < 0) continue;
      markers.offsets.row(t).segment<3>(at) =
          (world_from_joint[rules[m].offset_joint].linear() * rules[m].offset).transpose();
    }
  }
  return markers;
}

}  // namespace

absl::StatusOr<MarkerScheme> SourceScheme(const Motion& motion) {
  MarkerScheme scheme;
  scheme.set.name = "source";
  for (const std::string& name : PointNames(motion)) {
    const bool end_site = std::holds_alternative<JointMotion>(motion) && name.ends_with("_end");
    if (!end_site) scheme.set.markers.push_back(name);
  }
  if (scheme.set.markers.size() > kMaxMarkers) {
    return InvalidArgument(
        "the motion has {} joints or markers, expected at most {}: select some in a marker-set "
        "file",
        scheme.set.markers.size(), kMaxMarkers);
  }
  scheme.set.landmarks = RecognizeLandmarks(scheme.set.markers);
  if (scheme.set.landmarks.left_hip < 0 || scheme.set.landmarks.right_hip < 0) {
    return InvalidArgument(
        "no left and right hip among the {} names ('{}', ...): name the hips in a marker-set file",
        scheme.set.markers.size(), scheme.set.markers.empty() ? "" : scheme.set.markers.front());
  }
  return scheme;
}

absl::StatusOr<MarkerMotion> ApplyScheme(const MarkerScheme& scheme, const Motion& motion,
                                         std::optional<double> leg_length_m,
                                         const Cancelled& cancelled) {
  return ApplySchemeFrom(Eigen::Vector2d::Zero(), scheme, motion, leg_length_m, cancelled);
}

absl::StatusOr<MarkerMotion> ApplySchemeFrom(const Eigen::Vector2d& origin,
                                             const MarkerScheme& scheme, const Motion& motion,
                                             std::optional<double> leg_length_m,
                                             const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const BoundMapping mapping, BindMapping(scheme, PointNames(motion)));

  MarkerMotion mapped;
  mapped.names = scheme.set.markers;
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) {
    if (mapping.has_offsets) {
      return InvalidArgument("mapping '{}' has offsets in link frames, but the motion has no links",
                             mapping.name);
    }
    mapped.frame_rate_hz = markers->frame_rate_hz;
    mapped.positions_m = WeightedSums(mapping.rules, markers->positions_m, origin);
    return mapped;
  }
  const JointMotion& joints = std::get<JointMotion>(motion);
  mapped.frame_rate_hz = joints.frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(JointMarkers markers,
                            MarkersOfJoints(mapping, joints, origin, cancelled));
  mapped.positions_m = std::move(markers.positions_m);
  if (mapping.has_offsets) {
    if (!leg_length_m) {
      MOTIONDB_ASSIGN_OR_RETURN(leg_length_m, EstimateLegLength(scheme.set, mapped));
    }
    mapped.positions_m += (*leg_length_m * markers.offsets).cast<float>();
  }
  return mapped;
}

}  // namespace motiondb::core
