// A mapping to complete by hand.
#pragma once

#include <string>

#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// Returns a mapping with this name in the marker-set file's format to complete by hand: rules for
// the markers whose roles were found, with their confidences, and comments for the others. Markers
// with a default rule are left out.
std::string DraftMapping(const MarkerSet& set, const PointCloud& points, const std::string& name);

}  // namespace motiondb::core
