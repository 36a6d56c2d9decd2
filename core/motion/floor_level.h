// Height of the floor in a motion, from the feet that stand on it. Files differ: markers of one
// motion are up to 8 cm higher in one source than in another, because their skeletons are fitted or
// retargeted.
#pragma once

#include <optional>

#include "core/motion/marker_set.h"

namespace motiondb::core {

// Returns the height of the floor (m): standing ankles are 0.08 leg lengths above it (Winter,
// "Biomechanics and Motor Control of Human Movement"). Ankles stand while they move slower than 0.8
// leg lengths per second; their level is the median of their heights. Nothing if ankles stand for
// less than 0.1 s in total, if the set has no legs, or if the result is more than 0.15 leg lengths
// from z = 0: then the person does not stand, or the motion has another origin. O(frames).
std::optional<double> FloorLevel(const MarkerSet& set, const MarkerMotion& motion,
                                 double leg_length_m);

// Moves the motion up or down so that its floor is at z = 0, and returns the height (m) at which
// the floor was. Returns 0 if no floor was found.
double MoveToFloor(const MarkerSet& set, double leg_length_m, MarkerMotion& motion);

}  // namespace motiondb::core
