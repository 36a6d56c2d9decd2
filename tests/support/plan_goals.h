// Seeded random goals for planning.
#pragma once

#include <vector>

#include "core/planning/floor.h"

namespace motiondb::tests {

// Each is uniform: distance 1 to 4 m, bearing within 90 degrees of the start's front, final heading
// within 90 degrees of the bearing.
std::vector<core::FloorPose> RandomGoals(int count, unsigned seed);

}  // namespace motiondb::tests
