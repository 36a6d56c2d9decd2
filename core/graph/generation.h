// Motion generation probability (section IV-B): how probable it is that a transition graph
// generates an observation, summed over all node paths by the forward algorithm. Safe to call from
// any thread.
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

// log of the sum over all paths n_1 ... n_M of prod P_t(n_{i-1}, n_i) e_i(n_i), the first frame
// without a transition (eq. 7 summed). `transition_floor` is the probability of a transition never
// seen. `last`, where given, receives the distribution over nodes at the last frame (sums to 1;
// zeros where no path exists). -infinity where no path exists. O(frames * (nodes + edges)). Once
// cancelled it returns early, with what is of no use.
double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last = nullptr,
                     const Cancelled& cancelled = {});

// A node that an observed frame may be in, and the log density of the frame there.
struct LikelyNode {
  std::int32_t node = 0;
  float log_density = 0;
};

// LogGeneration where each frame (one at least) can only be in the nodes listed for it (each once,
// one at least). `floor` is above 0. O(nodes listed and their edges). `scratch` has a number for
// each node of the graph, all 0 before and after.
double LogGenerationAmong(const TransitionGraph& graph,
                          std::span<const std::vector<LikelyNode>> frames, double floor,
                          std::vector<double>& scratch);

}  // namespace motiondb::core
