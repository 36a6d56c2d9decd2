// Mapping of a figure to the standard marker set.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// Returns rules for the markers of the standard set, in the order of `set`. Points of the body that
// the motion lacks are derived from others by proportions of a person. A marker that cannot be
// derived has a rule without points: it is missing.
// INVALID_ARGUMENT if the figure has a problem or if a necessary role has a confidence below
// kMinRoleConfidence. REQUIRES: `set` has the markers of standard34.
absl::StatusOr<MarkerMapping> MapFigure(const MarkerSet& set, const Figure& figure,
                                        const PointCloud& points);

// Returns the markers of the standard set that MapFigure derives from distant points, because the
// figure has no point near them.
std::vector<std::string> DerivedMarkersOf(const Figure& figure, bool has_hierarchy);

// Returns the name of a role, such as "left knee".
std::string RoleName(Role role, Side side);

}  // namespace motiondb::core
