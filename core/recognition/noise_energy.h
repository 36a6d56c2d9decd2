// The noise of an observation, estimated from the observation alone.
#pragma once

#include "core/motion/matrix.h"

namespace motiondb::core {

// Returns the part of a frame's squared distance from any motion that is due to noise of the
// markers, mean over the frames: an estimate from successive frames of a window (frames x K, in the
// metric). Human motion is smooth, so differences between successive frames consist of noise. If
// the marker positions have independent noise in each frame, the positions of the states have white
// noise p, and their velocities, central differences of positions, have noise v. Squares of second
// differences have the mean 6 p + 5 v, those of third differences 20 p + 14 v; the result, 3/8 of
// the former less 1/16 of the latter, has the mean p + v. One-sided velocities, as of the newest
// frame, have more noise, so leave them out. 0 for fewer than 4 frames.
double NoiseEnergy(const Eigen::Ref<const FrameMatrix>& window);

}  // namespace motiondb::core
