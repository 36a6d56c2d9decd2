#include "core/motion/marker_rules.h"

#include <algorithm>
#include <unordered_map>

#include "core/motion/error.h"

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

std::vector<std::string> JointNames(const Skeleton& skeleton) {
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints()) names.push_back(joint.name);
  return names;
}

}  // namespace motiondb::core
