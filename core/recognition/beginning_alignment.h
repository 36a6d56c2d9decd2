// Aligns several beginnings of one observation with stored clips in one pass. All frames of a
// beginning except its newest are shared with longer beginnings.
#pragma once

#include <vector>

#include "core/motion/matrix.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class Model;

// Beginnings of one observation, in ascending order of length.
struct Beginnings {
  FrameMatrix states;        // frames x D, scaled, without NaN: the observation
  std::vector<int> lengths;  // frames of each beginning, at least 1, ascending
  // One row for each beginning: the state of its newest frame, with one-sided velocities, because
  // the next frame is unknown.
  FrameMatrix newest;
};

// Returns for each beginning the result of AlignWindow, anchored, for its compared frames
// (ComparedFrames from the start). Each beginning has its own shortlist. Costs as much as the
// longest beginning with all shortlisted clips. REQUIRES: at least one clip is not left out.
std::vector<WindowAlignment> AlignBeginnings(const Model& model, const Beginnings& beginnings,
                                             const std::vector<bool>& left_out);

}  // namespace motiondb::core
