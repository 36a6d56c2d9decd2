// An observation as recognition compares it with stored clips. Immutable; safe to share.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

struct MetricObservation {
  FrameMatrix states;     // frames x D, scaled; what was missing is filled in
  FrameMatrix projected;  // frames x K, in `own` if there is one, else in the model's metric
  // Where the observation never shows some dimensions: the metric of the others.
  std::shared_ptr<const MotionMetric> own;

  // From scaled states with NaN where a marker is missing. CANCELLED.
  static absl::StatusOr<MetricObservation> Create(const Model& model, FrameMatrix scaled,
                                                  const Cancelled& cancelled = {});

  const MotionMetric& MetricFor(const Model& model) const {
    return own == nullptr ? model.metric() : *own;
  }
};

// Which of the frames [first, first + width) are compared: every stride-th, ending with the newest.
// `from_start` takes frames first, first + stride, ... and then the newest: a stored clip is then
// compared from its own start.
std::vector<int> ComparedFrames(int first, int width, int stride, bool from_start);

}  // namespace motiondb::core
