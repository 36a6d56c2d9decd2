// Small synthetic motions, seeded.
#pragma once

#include <string>
#include <vector>

#include "core/model/model_builder.h"

namespace motiondb::tests {

// Returns a set of `markers` markers m0, m1, ... with hips and one leg.
core::MarkerSet SmallMarkerSet(int markers);

// Returns frames x dimensions states that move smoothly between a few places.
core::FrameMatrix WanderingStates(int frames, int dimensions, unsigned seed);

// Returns clips of wandering states, alternately labelled "a" and "b". Each label has its own
// places.
std::vector<core::BuildInput> WanderingClips(int clips, int frames, const core::MarkerSet& set,
                                             unsigned seed, double frame_rate_hz = 60);

// Builds a model of such clips.
core::Model SmallModel(int clips, int frames, int markers, int min_frames, unsigned seed);

}  // namespace motiondb::tests
