// Measures the difference between an extended model and a model built from the same clips.
#pragma once

#include "core/motion/execution.h"

namespace motiondb::core {

class Model;

struct ModelDifference {
  int bottom_nodes_before = 0;
  int bottom_nodes_after = 0;
  // Root mean square, over frames and dimensions, of the difference between a scaled state and the
  // mean of its bottom node.
  double spread_before = 0;
  double spread_after = 0;
  // Number of tested windows: at most 64 of 0.4 s, one for each added clip that is in both models.
  // A window is recognized without its own clip.
  int windows = 0;
  int same_label = 0;  // number of windows with the same most probable label in both models
};

// Compares the extended model `before` with the built model `after`; their clips may differ. The
// spreads use at most 20,000 evenly spread frames.
ModelDifference CompareModels(const Model& before, const Model& after, const ParallelFor& parallel);

}  // namespace motiondb::core
