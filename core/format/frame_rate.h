// Frame rates as files write them: a rounded frame time rarely gives the rate it was rounded from.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace motiondb::core {

// A frame rate (Hz) that motion can have: 0.001 to 100000.
bool IsFrameRate(double rate_hz);

// The whole rate, or the broadcast rate (23.976, 29.97, 59.94, 119.88), closest to `rate_hz` if it
// is within 0.1 percent of it, with a note if it differs; otherwise rate_hz.
double SnapFrameRate(double rate_hz, std::vector<std::string>& notes);

}  // namespace motiondb::core
