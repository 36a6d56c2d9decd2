// Motion generation probability (section IV-B): the probability that a transition graph generates
// an observation, summed over all node paths by the forward algorithm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

// frames x nodes: log probabilities (or densities) of each observed frame in each node of a graph.
using EmissionMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Returns the log of the sum over all paths n_1 ... n_M of prod P_t(n_{i-1}, n_i) e_i(n_i), without
// a transition for the first frame (eq. 7 summed); -infinity if no path exists. `transition_floor`:
// probability of an unseen transition. `last`, if not null, receives the distribution over nodes at
// the last frame (sums to 1; zeros if no path exists). Once cancelled, returns early with an
// undefined result. O(frames * (nodes + edges)).
double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last = nullptr,
                     const Cancelled& cancelled = {});

// A candidate node of an observed frame, with the log density of the frame in it.
struct LikelyNode {
  std::int32_t node = 0;
  float log_density = 0;
};

// As LogGeneration, with candidates restricted to the listed nodes: at least one frame, at least
// one node for each frame, no duplicates. `floor` > 0. `scratch`: one number for each node of the
// graph, all 0 before and after. O(listed nodes and their edges).
double LogGenerationOfCandidates(const TransitionGraph& graph,
                                 std::span<const std::vector<LikelyNode>> frames, double floor,
                                 std::vector<double>& scratch);

}  // namespace motiondb::core
