// Is an observation like anything stored? Its score under the global graph is compared with what
// the training motion itself scores. Immutable; safe to share.
#pragma once

#include <vector>

#include "core/graph/generation.h"
#include "core/graph/transition_graph.h"
#include "core/motion/matrix.h"
#include "core/tree/node_gaussians.h"
#include "core/tree/parallel.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// For each layer, the scores of training windows, ascending.
struct FamiliarityReference {
  std::vector<std::vector<float>> scores;  // [layer - 1][window]

  // Fraction of training windows that score lower, in [0, 1]; 0 where there is no window.
  double Rank(int layer, double score) const;
};

// What is compared: log density a frame under the graph, with a small floor for transitions never
// seen, whatever the query's own floor. `log_densities` is frames x nodes of the layer.
double FamiliarityScore(const TransitionGraph& graph,
                        const Eigen::Ref<const EmissionMatrix>& log_densities);

// Runs of frames [first, first + count) of the stored states.
struct FrameRun {
  int first = 0;
  int count = 0;
};

// Scores of windows of `window_frames` frames, spread evenly over the clips (at most 256 of them; a
// clip shorter than a window is one), on every layer. Nodes where a frame's log density is more
// than 40 below that in its own node are left out: with the floor of the score they change it by
// less than its rounding. O(windows * branches), a few dimensions each, and what the nodes that are
// left cost.
FamiliarityReference MakeFamiliarityReference(const std::vector<FrameRun>& clips, int window_frames,
                                              const Eigen::Ref<const FrameMatrix>& states,
                                              const Tree& tree, const NodeGaussians& gaussians,
                                              const std::vector<TransitionGraph>& global_graphs,
                                              const ParallelFor& parallel);

}  // namespace motiondb::core
