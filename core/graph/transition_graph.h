// Node transition graphs (section III-C, eq. 6): counts of transitions between nodes of one layer,
// over all clips or in one. Probabilities follow from counts. Immutable.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motiondb::core {

// One edge: `count` transitions from the row's node to `to`.
struct Edge {
  std::int32_t to = 0;
  std::int32_t count = 0;
  friend bool operator==(const Edge&, const Edge&) = default;
};

// Rows of edges, sorted by `to`; row k is edges[row_begin[k] .. row_begin[k + 1]).
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

}  // namespace motiondb::core
