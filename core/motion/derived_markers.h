// Markers of the standard set that a motion lacks, at the proportions of a person.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// A marker beside another one, in leg lengths: to the front of the body, and upwards.
struct DerivedMarker {
  const char* marker;
  const char* from;
  double front;
  double up;
};

// Feet and head of the standard set. The foot is 0.31 leg lengths long and the ankle 0.08 above its
// sole (Winter, "Biomechanics and Motor Control of Human Movement", after Drillis and Contini); the
// ankle is at a quarter of the foot's length, the ball at three quarters. The head is that of
// core/mapping/figure_mapping.cc.
std::span<const DerivedMarker> DerivedMarkers();

// Adds the markers of DerivedMarkers that `motion` lacks in all frames and whose base it has. Feet
// point to the front of the reference frame (ReferenceFrames), so this is an estimate for people
// who stand or walk. Appends one note with their names. INVALID_ARGUMENT if no frame has both hips.
absl::Status AddDerivedMarkers(const MarkerSet& set, double leg_length_m, MarkerMotion& motion,
                               std::vector<std::string>& notes);

}  // namespace motiondb::core
