#include "core/inference/observation.h"

#include <cmath>

#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<FrameMatrix> ScaledObservation(const Model& model,
                                              const StateSequence& observation) {
  if (observation.frame_count() == 0) return InvalidArgument("observation: it has no frames");
  if (observation.states.cols() != model.marker_set().dimension_count()) {
    return InvalidArgument("observation: expected states of {} numbers, got {}",
                           model.marker_set().dimension_count(), observation.states.cols());
  }
  if (std::abs(observation.frame_rate_hz - model.settings().frame_rate_hz) > 1e-6) {
    return InvalidArgument("observation: expected {} frames a second, got {}",
                           model.settings().frame_rate_hz, observation.frame_rate_hz);
  }
  if (observation.states.array().isInf().any()) {
    return InvalidArgument("observation: a number is infinite");
  }
  FrameMatrix scaled = observation.states;
  model.scale().Apply(scaled);
  return scaled;
}

}  // namespace motiondb::core
