// The points of the body that were found in a motion, for people who look at a file.
#pragma once

#include <string>
#include <vector>

#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

struct FoundRole {
  int point = -1;    // joint or marker
  std::string role;  // "left knee", or the anatomical landmark of an optical marker
  double confidence = 0;
};

// Returns the roles that MapAutomatically uses, also uncertain ones.
std::vector<FoundRole> FindRoles(const PointCloud& points);

// Returns a mapping in the marker-set file's format to complete by hand: rules for the markers
// whose roles were found, with their confidences, and comments for the others. Markers with a
// default rule are left out.
std::string DraftMapping(const MarkerSet& set, const PointCloud& points);

}  // namespace motiondb::core
