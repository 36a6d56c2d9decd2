// How far a plan is from stored motion: blending, the correction of its end, slowing and another
// body change stored frames.
#pragma once

#include <memory>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "core/planning/plan.h"

namespace motiondb::core {

class Model;

// Sets PlanQuality::unknown of a motion whose markers are complete. Recognizes windows of 0.4 s
// every 0.1 s among the clips that `mask` allows (null: all). CANCELLED.
absl::Status MeasureExtrapolation(const Model& model, const MarkerSet& set,
                                  std::shared_ptr<const ClipMask> mask, double leg_length_m,
                                  const Cancelled& cancelled, PlannedMotion& motion);

}  // namespace motiondb::core
