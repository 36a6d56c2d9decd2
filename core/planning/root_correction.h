// Bringing the end of a root path to the goal by a little at every step. Safe to call from any
// thread.
#pragma once

#include <vector>

#include "core/planning/floor.h"

namespace motiondb::core {

// What a correction may do: shift the path nowhere by more than this share of its length (before or
// after, whichever is less), and turn its end by no more radians than this share of its length in
// metres.
inline constexpr double kLargestCorrection = 0.05;

struct GoalError {
  double position_m = 0;   // not negative
  double heading_rad = 0;  // not negative
};

GoalError ErrorAt(const FloorPose& end, const FloorPose& goal);

// What will be left of the error once the end of a path of that length is corrected: an estimate
// without the path, by which most ends can be passed over.
GoalError ErrorAfterCorrection(const FloorPose& end, double length_m, const FloorPose& goal);

struct CorrectedRoot {
  std::vector<FloorPose> poses;
  double length_m = 0;         // of the path as it is now
  double largest_shift_m = 0;  // of any pose against the path as it was
  double turn_rad = 0;         // of the last pose; not negative
};

// Spreads turn and shift over the path in proportion to the way gone, so that who stands still is
// not moved. All of what is needed, or the share of it that is allowed. `root` is not empty.
CorrectedRoot CorrectRoot(const std::vector<FloorPose>& root, const FloorPose& goal);

}  // namespace motiondb::core
