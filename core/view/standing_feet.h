// Which feet stand on the floor.
#pragma once

#include <cstdint>
#include <vector>

#include "core/motion/marker_set.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

inline constexpr std::uint8_t kLeftFoot = 1;
inline constexpr std::uint8_t kRightFoot = 2;

// Returns, for each frame, the feet (bits) of which a marker is in contact (DetectContacts). Empty
// if there are no feet. `positions_m`: frames x 3 N_v, world, floor at z = 0. O(frames * contact
// markers).
std::vector<std::uint8_t> StandingFeet(const MarkerSet& set, const Feet& feet,
                                       const FrameMatrix& positions_m, double frame_rate_hz,
                                       double leg_length_m);

}  // namespace motiondb::core
