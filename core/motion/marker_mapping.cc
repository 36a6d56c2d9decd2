#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

using NameIndex = std::unordered_map<std::string, int>;

std::vector<std::string> PointNames(const Motion& motion) {
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) return markers->names;
  std::vector<std::string> names;
  for (const Joint& joint : std::get<JointMotion>(motion).skeleton->joints()) {
    names.push_back(joint.name);
  }
  return names;
}

NameIndex IndexOf(const std::vector<std::string>& names) {
  NameIndex index;
  for (std::size_t i = 0; i < names.size(); ++i) index.emplace(names[i], static_cast<int>(i));
  return index;
}

std::vector<std::string> Lacking(const std::vector<std::string>& wanted, const NameIndex& index) {
  std::vector<std::string> lacking;
  for (const std::string& name : wanted) {
    if (!index.contains(name)) lacking.push_back(name);
  }
  return lacking;
}

// The set's own names on the motion: every marker is the point of its name.
MarkerMapping IdentityMapping(const MarkerSet& set) {
  MarkerMapping mapping{"own names", set.markers, {}};
  for (const std::string& marker : set.markers) {
    mapping.rules.push_back({{{marker, 1}}, "", Eigen::Vector3d::Zero()});
  }
  return mapping;
}

absl::StatusOr<MarkerMapping> ChooseMapping(const MarkerScheme& scheme, const NameIndex& index) {
  std::vector<MarkerMapping> known = scheme.mappings;
  known.push_back(IdentityMapping(scheme.set));
  const MarkerMapping* best = nullptr;
  const MarkerMapping* closest = nullptr;
  double closest_share = -1;
  for (const MarkerMapping& mapping : known) {
    const auto total = static_cast<double>(std::max<std::size_t>(1, mapping.signature.size()));
    const double share = 1 - static_cast<double>(Lacking(mapping.signature, index).size()) / total;
    if (share == 1 && (best == nullptr || mapping.signature.size() > best->signature.size())) {
      best = &mapping;
    }
    if (share > closest_share) {
      closest_share = share;
      closest = &mapping;
    }
  }
  if (best != nullptr) return *best;
  const auto lacking = Lacking(closest->signature, index);
  return InvalidArgument(
      "no mapping of marker set '{}' fits this motion: the closest, '{}', needs '{}'{}, which is "
      "not "
      "among its joints or markers; add a mapping to a marker-set file",
      scheme.set.name, closest->name, lacking.front(),
      lacking.size() > 1 ? fmt::format(" and {} more", lacking.size() - 1) : "");
}

// The mapping's points and links as indices.
struct ResolvedRule {
  std::vector<std::pair<int, double>> points;
  int offset_joint = -1;
  Eigen::Vector3d offset;
};

absl::StatusOr<std::vector<ResolvedRule>> Resolve(const MarkerScheme& scheme,
                                                  const MarkerMapping& mapping,
                                                  const NameIndex& index) {
  std::vector<ResolvedRule> resolved;
  for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
    const MarkerRule& rule = mapping.rules[m];
    ResolvedRule& made = resolved.emplace_back();
    made.offset = rule.offset;
    const auto find = [&](const std::string& name) -> absl::StatusOr<int> {
      const auto at = index.find(name);
      if (at != index.end()) return at->second;
      return InvalidArgument("mapping '{}' makes marker '{}' from '{}', which the motion lacks",
                             mapping.name, scheme.set.markers[m], name);
    };
    for (const WeightedPoint& point : rule.points) {
      MOTIONDB_ASSIGN_OR_RETURN(const int at, find(point.name));
      made.points.emplace_back(at, point.weight);
    }
    if (!rule.offset_joint.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(made.offset_joint, find(rule.offset_joint));
    }
  }
  return resolved;
}

FrameMatrix WeightedSums(const std::vector<ResolvedRule>& rules, const FrameMatrix& points) {
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
void AddOffsets(const std::vector<ResolvedRule>& rules, const JointMotion& motion,
                double leg_length_m, FrameMatrix& positions) {
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
  const NameIndex index = IndexOf(PointNames(motion));
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMapping mapping, ChooseMapping(scheme, index));
  MOTIONDB_ASSIGN_OR_RETURN(const auto rules, Resolve(scheme, mapping, index));
  const bool offsets = std::any_of(rules.begin(), rules.end(),
                                   [](const ResolvedRule& rule) { return rule.offset_joint >= 0; });

  MarkerMotion mapped;
  mapped.names = scheme.set.markers;
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) {
    if (offsets) {
      return InvalidArgument("mapping '{}' has offsets in link frames, which bare markers lack",
                             mapping.name);
    }
    mapped.frame_rate_hz = markers->frame_rate_hz;
    mapped.positions_m = WeightedSums(rules, markers->positions_m);
    return mapped;
  }
  const JointMotion& joints = std::get<JointMotion>(motion);
  mapped.frame_rate_hz = joints.frame_rate_hz;
  mapped.positions_m = WeightedSums(rules, JointPositions(joints));
  if (offsets) {
    if (!leg_length_m) {
      MOTIONDB_ASSIGN_OR_RETURN(leg_length_m, EstimateLegLength(scheme.set, mapped));
    }
    AddOffsets(rules, joints, *leg_length_m, mapped.positions_m);
  }
  return mapped;
}

}  // namespace motiondb::core
