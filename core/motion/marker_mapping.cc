#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/motion_floor.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

using NameIndex = std::unordered_map<std::string, int>;

NameIndex IndexOf(const std::vector<std::string>& names) {
  NameIndex index;
  for (std::size_t i = 0; i < names.size(); ++i) index.emplace(names[i], static_cast<int>(i));
  return index;
}

std::vector<std::string> MissingNames(const std::vector<std::string>& required,
                                      const NameIndex& index) {
  std::vector<std::string> missing;
  for (const std::string& name : required) {
    if (!index.contains(name)) missing.push_back(name);
  }
  return missing;
}

// Maps every marker to the point with the same name.
MarkerMapping IdentityMapping(const MarkerSet& set) {
  MarkerMapping mapping{"own names", set.markers, {}};
  for (const std::string& marker : set.markers) {
    mapping.rules.push_back({{{marker, 1}}, "", Eigen::Vector3d::Zero()});
  }
  return mapping;
}

absl::StatusOr<MarkerMapping> ChooseMapping(const MarkerScheme& scheme, const NameIndex& index) {
  const MarkerMapping own_names = IdentityMapping(scheme.set);
  const MarkerMapping* best = nullptr;
  const MarkerMapping* closest = nullptr;
  double closest_share = -1;
  const auto consider = [&](const MarkerMapping& mapping) {
    const auto total = static_cast<double>(std::max<std::size_t>(1, mapping.signature.size()));
    const auto missing = std::ranges::count_if(
        mapping.signature, [&](const std::string& name) { return !index.contains(name); });
    const double share = 1 - static_cast<double>(missing) / total;
    if (share == 1 && (best == nullptr || mapping.signature.size() > best->signature.size())) {
      best = &mapping;
    }
    if (share > closest_share) {
      closest_share = share;
      closest = &mapping;
    }
  };
  for (const MarkerMapping& mapping : scheme.mappings) consider(mapping);
  consider(own_names);
  if (best != nullptr) return *best;
  const auto missing = MissingNames(closest->signature, index);
  return InvalidArgument(
      "no mapping of marker set '{}' fits this motion: the closest, '{}', needs '{}'{}, missing "
      "from its joints or markers; add a mapping (motiondb mapping add DB FILE)",
      scheme.set.name, closest->name, missing.front(),
      missing.size() > 1 ? fmt::format(" and {} more", missing.size() - 1) : "");
}

}  // namespace

absl::StatusOr<BoundMapping> BindMapping(const MarkerScheme& scheme,
                                         const std::vector<std::string>& names) {
  const NameIndex index = IndexOf(names);
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMapping mapping, ChooseMapping(scheme, index));
  if (mapping.rules.size() != scheme.set.markers.size()) {
    return InvalidArgument("mapping '{}' has {} rules for the {} markers of set '{}'", mapping.name,
                           mapping.rules.size(), scheme.set.markers.size(), scheme.set.name);
  }
  BoundMapping bound{.name = mapping.name, .rules = {}};
  for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
    const MarkerRule& rule = mapping.rules[m];
    BoundRule& made = bound.rules.emplace_back();
    made.offset = rule.offset;
    const auto find = [&](const std::string& name) -> absl::StatusOr<int> {
      const auto at = index.find(name);
      if (at != index.end()) return at->second;
      return InvalidArgument("mapping '{}', marker '{}': the motion has no joint or marker '{}'",
                             mapping.name, scheme.set.markers[m], name);
    };
    for (const WeightedPoint& point : rule.points) {
      MOTIONDB_ASSIGN_OR_RETURN(const int at, find(point.name));
      made.points.emplace_back(at, point.weight);
    }
    if (!rule.offset_joint.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(made.offset_joint, find(rule.offset_joint));
      bound.has_offsets = true;
    }
  }
  return bound;
}

int MarkerSet::FindMarker(std::string_view marker) const {
  for (int m = 0; m < marker_count(); ++m) {
    if (markers[m] == marker) return m;
  }
  return -1;
}

std::vector<std::string> JointNames(const Skeleton& skeleton) {
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints()) names.push_back(joint.name);
  return names;
}

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
