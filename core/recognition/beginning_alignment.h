// Aligns several beginnings of one observation with stored units in one pass. All frames of a
// beginning except its newest are shared with longer beginnings.
#pragma once

#include <vector>

#include "core/motion/matrix.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class ClipMask;
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
// longest beginning with all shortlisted clips. `mask` and `left_out_label` as
// for AlignWindow.
std::vector<WindowAlignment> AlignBeginnings(const Model& model, const LabelUnits& units,
                                             const Beginnings& beginnings,
                                             const ClipMask* mask = nullptr,
                                             int left_out_label = -1);

}  // namespace motiondb::core
