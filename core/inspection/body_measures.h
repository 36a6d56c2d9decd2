// Measures of a person on the markers of standard34.
#pragma once

#include <optional>

#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Returns the stature (m): median length of the segments from ankle to top of the head, and the
// height of the ankle. Nothing if a marker is missing in all frames. REQUIRES: `motion` has the
// markers of standard34.
std::optional<double> Stature(const MarkerMotion& motion, double leg_length_m);

// Returns the median horizontal speed (m/s) of the heels and toes while they are near the floor,
// which is where they are lowest. Nothing if no foot is near the floor for long enough. 0.1 and
// more is visible sliding. REQUIRES: as above.
std::optional<double> FootSlide(const MarkerMotion& motion, double leg_length_m);

}  // namespace motiondb::core
