// Synthetic walking bodies as marker positions, and a database of them.
#pragma once

#include "core/model/model.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::tests {

inline constexpr double kLegLength_m = 0.8;

// Six markers with hips and a leg.
core::MarkerScheme PointScheme();

// A body that moves along an arc; its other markers wander like WanderingStates. Motions of one
// seed differ only by a little noise, selected by `variant`.
core::MarkerMotion PointMotion(int frames, unsigned seed, unsigned variant,
                               double frame_rate_hz = 60);

// A model of clips of 150 frames with labels "a", "b", ..., one seed per label; with a familiarity
// scale if `calibrated`.
core::Model PointModel(int labels, int clips_each, bool calibrated = true);

// Returns the states of a whole observation.
core::StateSequence PointStates(const core::MarkerMotion& motion);

// Sets a marker missing in frames [first, end).
void Hide(core::MarkerMotion& motion, int marker, Eigen::Index first, Eigen::Index end);

}  // namespace motiondb::tests
