// Motion with left and right exchanged: as good an example as the motion itself. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

// For each marker the index of the one on the other side, its own for one in the middle; told by
// names that begin with Left and Right, left and right, L and R, or l and r. Empty where no marker
// has another on the other side.
std::vector<int> OtherSides(const std::vector<std::string>& markers);

// Positions (rows x 3 N_v) with x to the front, y to the left, seen in a mirror: markers exchanged,
// y negated.
FrameMatrix MirrorPositions(const std::vector<int>& other_sides, const FrameMatrix& positions);

// The same of states (rows x 6 N_v).
FrameMatrix MirrorStates(const std::vector<int>& other_sides, const FrameMatrix& states);

}  // namespace motiondb::core
