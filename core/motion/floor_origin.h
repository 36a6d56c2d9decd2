// Motion far from the world's origin. A float has steps of 8 mm at 90 km, so positions become
// floats relative to a point of the floor near the motion. Pure; safe to call from any thread.
#pragma once

#include <optional>

#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// The corner of a grid of 16 m that is nearest to a point of the floor (x, y in m): 0 for all
// motion near the origin, whose numbers stay as they are.
Eigen::Vector2d NearestCorner(const Eigen::Vector2d& point);

// A corner near the first place of the root or of a marker.
Eigen::Vector2d FloorOrigin(const Motion& motion);

// As ApplyScheme, with positions relative to `origin`.
absl::StatusOr<MarkerMotion> ApplySchemeFrom(const Eigen::Vector2d& origin,
                                             const MarkerScheme& scheme, const Motion& motion,
                                             std::optional<double> leg_length_m,
                                             const Cancelled& cancelled);

}  // namespace motiondb::core
