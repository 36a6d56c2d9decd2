// The goal of a plan, before the search.
#pragma once

#include <string>

#include "core/planning/plan.h"
#include "core/planning/splice.h"

namespace motiondb::core {

// Returns a reason why no search can succeed; empty if there is none. O(obstacles).
std::string WhyUnreachable(const PlanProblem& problem, const StoredFloor& floor);

// Returns the goal, or, if it is too near an obstacle, the nearest clear position within its
// tolerance. O(obstacles).
FloorPose AimFor(const PlanProblem& problem);

}  // namespace motiondb::core
