// Mirror images: motion with left and right exchanged.
#pragma once

#include <string>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

// Returns, for each marker, the index of its counterpart on the other side; its own index if it has
// none. Counterparts differ in the prefix: Left/Right, left/right, L/R or l/r. Empty if no marker
// has a counterpart.
std::vector<int> OtherSides(const std::vector<std::string>& markers);

// Returns the mirror image of positions (rows x 3 N_v; x to the front, y to the left): counterparts
// exchanged, y negated.
FrameMatrix MirrorPositions(const std::vector<int>& other_sides, const FrameMatrix& positions);

// As above, for states (rows x 6 N_v).
FrameMatrix MirrorStates(const std::vector<int>& other_sides, const FrameMatrix& states);

}  // namespace motiondb::core
