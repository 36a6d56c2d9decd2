// Familiarity under the global graph: compares the score of an observation with the scores of
// stored windows. Immutable.
#pragma once

#include <vector>

#include "core/graph/transition_graph.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/node_gaussians.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// Scores of stored windows, ascending, for each layer.
struct FamiliarityReference {
  std::vector<std::vector<float>> scores;  // [layer - 1][window]

  // Returns the fraction of stored windows with a lower score, 0 to 1; 0 if there is no window.
  double Rank(int layer, double score) const;
};

// Returns the mean log density of a frame under the graph, with a fixed floor for unseen
// transitions. log_densities: frames x nodes of the layer.
double FamiliarityScore(const TransitionGraph& graph,
                        const Eigen::Ref<const EmissionMatrix>& log_densities);

// Runs of frames [first, first + count) of the stored states.
struct FrameRun {
  int first = 0;
  int count = 0;
};

// Returns the scores of at most 256 windows of `window_frames` frames, evenly spread over the
// clips, on each layer. A clip shorter than a window is one window. Skips nodes in which the log
// density of a frame is more than 40 below that in its own node: because of the floor, their effect
// is below the rounding of the score. O(windows * branches) bounding box tests on a few dimensions,
// plus the densities of the remaining nodes.
FamiliarityReference MakeFamiliarityReference(const std::vector<FrameRun>& clips, int window_frames,
                                              const Eigen::Ref<const FrameMatrix>& states,
                                              const Tree& tree, const NodeGaussians& gaussians,
                                              const std::vector<TransitionGraph>& global_graphs,
                                              const ParallelFor& parallel);

}  // namespace motiondb::core
