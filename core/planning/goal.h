// The goal of a plan: whether a search can reach it, where to aim, and the correction of a root
// path so that it ends at the goal, spread over its steps.
#pragma once

#include <string>
#include <vector>

#include "core/planning/floor.h"
#include "core/planning/plan.h"
#include "core/planning/splice.h"

namespace motiondb::core {

// Returns a reason why no search can succeed; empty if there is none. O(obstacles).
std::string WhyUnreachable(const PlanProblem& problem, const StoredFloor& floor);

// Returns the goal, or, if it is too near an obstacle, the nearest clear position within its
// tolerance. O(obstacles).
FloorPose AimFor(const PlanProblem& problem);

// Limits of a correction: the shift of any pose as a fraction of the path length (before or after,
// whichever is smaller), and the rotation of the end (rad) per metre of path length.
inline constexpr double kMaxCorrection = 0.05;

struct GoalError {
  double position_m = 0;   // not negative
  double heading_rad = 0;  // not negative
};

GoalError ErrorAt(const FloorPose& end, const FloorPose& goal);

// Estimates the remaining error after correction of a path of this length, without the path: a
// cheap filter for most ends.
GoalError ErrorAfterCorrection(const FloorPose& end, double length_m, const FloorPose& goal);

struct CorrectedRoot {
  std::vector<FloorPose> poses;
  double length_m = 0;         // of the corrected path
  double largest_shift_m = 0;  // of any pose, relative to the original path
  double turn_rad = 0;         // of the last pose, not negative
};

// Distributes rotation and shift over the path in proportion to the distance covered, so that
// standing is not moved. Applies all of the needed correction, or the allowed fraction. `root` is
// not empty.
CorrectedRoot CorrectRoot(const std::vector<FloorPose>& root, const FloorPose& goal);

}  // namespace motiondb::core
