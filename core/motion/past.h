// What had been observed at a moment, and nothing after it. Pure function.
#pragma once

#include "core/motion/states.h"

namespace motiondb::core {

// The last `history` frames, at least one, up to `frame` (fewer at the beginning). Velocities of
// the last frame must not know the next one: they become backward differences.
StateSequence PastAt(const StateSequence& observation, int frame, int history);

}  // namespace motiondb::core
