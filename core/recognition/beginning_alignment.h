// Aligns several beginnings of one observation with stored clips in one pass: beginnings share all
// frames but their newest. Safe to call from any thread.
#pragma once

#include <vector>

#include "core/motion/matrix.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class Model;

// Beginnings of one observation, from its first frame on, the shortest first.
struct Beginnings {
  FrameMatrix states;        // frames x D, scaled, without NaN: the observation
  std::vector<int> lengths;  // frames of each beginning, at least 1, ascending
  // One row for each beginning: the state of its newest frame as that beginning shows it. Its
  // velocities are one-sided, for nothing after it is known.
  FrameMatrix newest;
};

// For each beginning, the result of AlignWindow for its compared frames (ComparedFrames, from the
// start), anchored: every beginning has a shortlist of its own. One clip at least is not left out.
// The cost is that of the longest beginning, with the clips on the shortlist of any.
std::vector<WindowAlignment> AlignBeginnings(const Model& model, const Beginnings& beginnings,
                                             const std::vector<bool>& left_out);

}  // namespace motiondb::core
