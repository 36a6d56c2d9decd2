// The points of a motion in one frame, and the markers of a database that are computed from them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// A joint or marker of the motion.
struct SourcePoint {
  std::string name;
  int parent = -1;                     // -1: a root joint or a marker
  std::array<double, 3> position_m{};  // world; NaN: missing
  std::vector<std::string> markers;    // of the scheme, in its order
};

struct SourcePoints {
  std::vector<SourcePoint> points;
  std::string mapping;       // its name; empty: the points have the names of the markers
  std::string mapping_text;  // see WriteMapping
};

// Positions are those of the first frame with the most points: the first complete one, if there is
// one. INVALID_ARGUMENT if no mapping fits; see FitScheme. O(joints) for each of 24 frames, and
// O(markers) for each frame.
absl::StatusOr<SourcePoints> FindSourcePoints(const MarkerScheme& scheme, const Motion& motion);

}  // namespace motiondb::core
