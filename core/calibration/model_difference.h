// Difference between an extended model and a model built from the same clips.
#pragma once

#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

struct ModelDifference {
  int bottom_nodes_before = 0;
  int bottom_nodes_after = 0;
  // Root mean square, over frames and dimensions, of the difference between a scaled frame and the
  // mean of its bottom node.
  double spread_before = 0;
  double spread_after = 0;
  // Number of tested windows: at most 64, 0.4 s long, from added clips, each recognized without its
  // own clip. And the number of windows with the same most probable label in both models.
  int windows = 0;
  int same_label = 0;
};

// `before` is the extended model, `after` the built one; their clips may differ. Uses at most
// 20,000 frames, evenly spread.
ModelDifference CompareModels(const Model& before, const Model& after, const ParallelFor& parallel);

}  // namespace motiondb::core
