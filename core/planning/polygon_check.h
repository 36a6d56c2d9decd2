// Whether a polygon has an inside. Safe to call from any thread.
#pragma once

#include "absl/status/status.h"
#include "core/planning/obstacles.h"

namespace motiondb::core {

// INVALID_ARGUMENT, saying which corners, for a polygon with a corner that is not finite, with
// fewer than three different corners in a row, or whose line crosses, touches or goes back along
// itself. A corner that repeats the one before it, or the first at the end, does no harm. O(n log
// n) for n corners of shapes as people draw them, O(n^2) for the worst.
absl::Status CheckPolygon(const Polygon& polygon);

}  // namespace motiondb::core
