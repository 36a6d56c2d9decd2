// How many joints a file may have. A skeleton is stored, read and sent whole, and counts in no
// quota; a body with hands and a face has about two hundred.
#pragma once

namespace motiondb::core {

inline constexpr int kMostJoints = 2000;  // end sites and the tips of bones among them

}  // namespace motiondb::core
