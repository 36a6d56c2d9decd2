// How large marker sets may be. A model's statistics grow with the square of a set's size and its
// metric with the cube, so a set from a file of a megabyte could ask for terabytes and years.
#pragma once

#include <cstddef>

namespace motiondb::core {

inline constexpr std::size_t kMostMarkers = 256;  // seven times the standard set; faces have fewer
inline constexpr std::size_t kMostMappings = 200;
inline constexpr std::size_t kMostRulePoints = 32;  // that one virtual marker is made from

}  // namespace motiondb::core
