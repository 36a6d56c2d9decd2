// What every query does with its observation first.
#pragma once

#include "absl/status/statusor.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// The observation's states (frames x dimensions), scaled as the model's. INVALID_ARGUMENT if it is
// empty, has another marker set or frame rate than the model, or an infinite number.
absl::StatusOr<FrameMatrix> ScaledObservation(const Model& model, const StateSequence& observation);

}  // namespace motiondb::core
