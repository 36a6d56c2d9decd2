// A marker mapping bound to one skeleton or marker list: names resolved to indices.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// A MarkerRule with indices instead of names.
struct BoundRule {
  std::vector<std::pair<int, double>> points;  // joint or source marker, and its weight
  int offset_joint = -1;                       // -1: no offset
  Eigen::Vector3d offset;                      // in that joint's frame, in leg lengths
};

struct BoundMapping {
  std::string name;
  std::vector<BoundRule> rules;  // one for each marker of the set
  bool has_offsets = false;
};

// Returns the mapping with the largest signature among those that fit `names`, bound to them; the
// mapping "own names", which is not in the scheme, if the points have the names of the markers.
// INVALID_ARGUMENT if none fits (the message names what the closest mapping lacks) or if a rule
// uses an unknown name.
absl::StatusOr<BoundMapping> BindMapping(const MarkerScheme& scheme,
                                         const std::vector<std::string>& names);

std::vector<std::string> JointNames(const Skeleton& skeleton);

}  // namespace motiondb::core
