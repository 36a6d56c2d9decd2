// Node transition graphs (section III-C, eq. 6): counts of transitions between nodes of one layer,
// over all clips or in one; probabilities follow from counts. Also the probability that a graph
// generates an observation, summed over all node paths by the forward algorithm (section IV-B).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/execution.h"

namespace motiondb::core {

// One edge: `count` transitions from the row's node to `to`.
struct Edge {
  std::int32_t to = 0;
  std::int32_t count = 0;
  friend bool operator==(const Edge&, const Edge&) = default;
};

// Rows of edges, sorted by `to`; row k is edges[row_begin[k] .. row_begin[k + 1]). Immutable.
class TransitionGraph {
 public:
  TransitionGraph() = default;
  // `row_begin` has node_count + 1 entries, ascending from 0 to edges.size(); counts are positive.
  TransitionGraph(std::vector<std::int32_t> row_begin, std::vector<Edge> edges);

  int node_count() const { return static_cast<int>(row_begin_.size()) - 1; }
  int edge_count() const { return static_cast<int>(edges_.size()); }
  std::span<const Edge> row(int from) const {
    return {edges_.data() + row_begin_[from], edges_.data() + row_begin_[from + 1]};
  }
  // Sum of the counts from a node; 0 if it occurs only at the end of clips.
  std::int64_t row_sum(int from) const { return row_sums_[from]; }
  std::int32_t count(int from, int to) const;
  // Returns eq. 6; 0 for an unseen transition. O(log of the row's length).
  double probability(int from, int to) const {
    const std::int32_t seen = count(from, to);
    return seen == 0 ? 0.0 : static_cast<double>(seen) / static_cast<double>(row_sum(from));
  }

  const std::vector<std::int32_t>& row_begin() const { return row_begin_; }
  const std::vector<Edge>& edges() const { return edges_; }

 private:
  std::vector<std::int32_t> row_begin_{0};
  std::vector<Edge> edges_;
  std::vector<std::int64_t> row_sums_;
};

// Counts the transitions between successive frames of node sequences (one node for each frame).
// Each clip is a separate sequence: transitions across clips do not count.
TransitionGraph CountTransitions(std::span<const std::vector<std::int32_t>> sequences,
                                 int node_count);

// Returns the graph with the summed counts of both, which have the same node count.
TransitionGraph MergeGraphs(const TransitionGraph& a, const TransitionGraph& b);

// A clip's graph, restricted to the nodes that it visits. Its states are numbered in node order.
struct ClipGraph {
  std::vector<std::int32_t> nodes;   // state -> node of the layer, ascending
  std::vector<std::int32_t> frames;  // frames of the clip in each
  TransitionGraph transitions;       // between states
};

ClipGraph CountClipTransitions(std::span<const std::int32_t> sequence);

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
