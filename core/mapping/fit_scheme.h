// Chooses the mapping of a motion: one of the scheme's, or an automatic one; and the roles found,
// for inspection.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

struct AutomaticMapping {
  MarkerMapping mapping;
  std::string note;                  // how it was found
  std::vector<std::string> derived;  // markers without a point near them
};

// Maps anatomical landmarks (core/mapping/skin_markers.h) if the points have labels of optical
// markers, otherwise a figure (core/mapping/figure.h). INVALID_ARGUMENT: what is missing or
// uncertain. REQUIRES: `set` has the markers of standard34.
absl::StatusOr<AutomaticMapping> MapAutomatically(const MarkerSet& set, const PointCloud& points);

// Returns INVALID_ARGUMENT if points with these names cannot be mapped automatically, whatever
// their positions.
absl::Status CheckPointNames(const std::vector<std::string>& names);

// Stored clips have all markers; in an observation, derived markers are missing.
enum class FitFor { kClip, kQuery };

// Returns the scheme if one of its mappings fits the motion. Otherwise, if its set is standard34,
// returns the set with an automatic mapping of this motion, and sets `note`, if not null, to how it
// was found. INVALID_ARGUMENT if there is no mapping: what was found, and what to do. O(joints) for
// each of 24 frames.
absl::StatusOr<MarkerScheme> FitScheme(const MarkerScheme& scheme, const Motion& motion,
                                       FitFor purpose, std::string* note = nullptr);

// A point of the body that was found in a motion, for people who look at a file.
struct FoundRole {
  int point = -1;    // joint or marker
  std::string role;  // "left knee", or the anatomical landmark of an optical marker
  double confidence = 0;
};

// Returns the roles that MapAutomatically uses, also uncertain ones.
std::vector<FoundRole> FindRoles(const PointCloud& points);

}  // namespace motiondb::core
