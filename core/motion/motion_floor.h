// The floor of a motion: its height, and a point on it near the motion.
//
// Files differ in height: markers of one motion are up to 8 cm higher in one source than in
// another, because their skeletons are fitted or retargeted. Motion may be far from the world's
// origin: at 90 km a float has a resolution of 8 mm, so positions are stored as floats relative to
// a point on the floor near the motion.
#pragma once

#include <optional>

#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

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

// Returns the point of a 16 m grid that is nearest to `point` (x, y in m). It is 0 near the origin,
// so that such motion keeps its coordinates.
Eigen::Vector2d NearestCorner(const Eigen::Vector2d& point);

// Returns the grid point nearest to the first valid position of the root or of a marker.
Eigen::Vector2d FloorOrigin(const Motion& motion);

// As ApplyScheme, with positions relative to `origin`.
absl::StatusOr<MarkerMotion> ApplySchemeFrom(const Eigen::Vector2d& origin,
                                             const MarkerScheme& scheme, const Motion& motion,
                                             std::optional<double> leg_length_m,
                                             const Cancelled& cancelled);

}  // namespace motiondb::core
