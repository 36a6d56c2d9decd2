// Motion far from the world's origin. At 90 km a float has a resolution of 8 mm, so positions are
// stored as floats relative to a point on the floor near the motion.
#pragma once

#include <optional>

#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

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
