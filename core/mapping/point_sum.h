// Weighted sums of the points of a motion.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/marker_set.h"

namespace motiondb::core {

// Point index to weight; weights sum to 1, or to 0 for a difference. Empty: unknown.
using PointSum = std::map<int, double>;

// Returns the weighted total; empty if one of the sums is.
PointSum Total(const std::vector<std::pair<double, PointSum>>& sums);

// Returns a + share * (b - a).
PointSum Between(const PointSum& a, const PointSum& b, double share);

// Returns a mapping with the sums as rules of the set's markers. A marker without a sum is missing.
// `names`: of the points.
MarkerMapping MappingFrom(const MarkerSet& set, const std::map<std::string, PointSum>& markers,
                          const std::vector<std::string>& names);

}  // namespace motiondb::core
