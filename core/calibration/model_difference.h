// How much a model that was extended by clips differs from one that was built of the same clips.
// Pure functions; safe to call from any thread.
#pragma once

#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

struct ModelDifference {
  int bottom_nodes_before = 0;
  int bottom_nodes_after = 0;
  // Root of the mean square, over frames and dimensions, of the scaled difference of a frame from
  // the mean of its bottom node.
  double spread_before = 0;
  double spread_after = 0;
  // Windows of 0.4 s of the clips that were added, at most 64, each asked about without its own
  // clip; and for how many of them both models find the same label most probable.
  int windows = 0;
  int same_label = 0;
};

// `before` is the extended model, `after` the built one, which may lack clips or have others. Looks
// at some 20,000 frames, evenly spread.
ModelDifference CompareModels(const Model& before, const Model& after, const ParallelFor& parallel);

}  // namespace motiondb::core
