// Made-up bodies that walk about, as marker positions and as a database of them.
#pragma once

#include "core/model/model.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::tests {

inline constexpr double kLegLength_m = 0.8;

// Six markers with hips and a leg.
core::MarkerScheme PointScheme();

// A body that goes round in an arc, with markers beside the hips that wander as WanderingStates do.
// Motions of one seed are alike but for a little noise, which `variant` tells apart.
core::MarkerMotion PointMotion(int frames, unsigned seed, unsigned variant,
                               double frame_rate_hz = 60);

// Clips of 150 frames of the labels "a", "b", ..., one seed each; with a familiarity scale if
// `calibrated`.
core::Model PointModel(int labels, int clips_each, bool calibrated = true);

// A whole observation's states.
core::StateSequence PointStates(const core::MarkerMotion& motion);

// Clears a marker in the frames [first, end).
void Hide(core::MarkerMotion& motion, int marker, Eigen::Index first, Eigen::Index end);

}  // namespace motiondb::tests
