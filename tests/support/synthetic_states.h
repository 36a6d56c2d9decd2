// Small motions that tests make up: seeded, so that every run sees the same.
#pragma once

#include <string>
#include <vector>

#include "core/model/model_builder.h"

namespace motiondb::tests {

// A marker set of `markers` markers m0, m1, ... with hips and one leg.
core::MarkerSet SmallMarkerSet(int markers);

// frames x dimensions of states that wander smoothly between a few places, as motion does.
core::FrameMatrix WanderingStates(int frames, int dimensions, unsigned seed);

// Clips of wandering states, labelled "a" and "b" in turn, each label in places of its own.
std::vector<core::BuildInput> WanderingClips(int clips, int frames, const core::MarkerSet& set,
                                             unsigned seed, double frame_rate_hz = 60);

// A model of such clips.
core::Model SmallModel(int clips, int frames, int markers, int min_frames, unsigned seed);

}  // namespace motiondb::tests
