// How far a plan is from stored motion: blending, the correction of its end, slowing and another
// body change stored frames.
#pragma once

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "core/planning/plan.h"

namespace motiondb::core {

class Model;

// Sets PlanQuality::unknown of a motion whose markers are complete. Recognizes windows of 0.4 s
// every 0.1 s. CANCELLED.
absl::Status MeasureExtrapolation(const Model& model, const MarkerSet& set, double leg_length_m,
                                  const Cancelled& cancelled, PlannedMotion& motion);

}  // namespace motiondb::core
