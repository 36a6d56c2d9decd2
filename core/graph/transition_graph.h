// Node transition graphs (section III-C, eq. 6): how often each node of a layer follows each other,
// in all clips or in one. Counts are kept; probabilities follow. Immutable; safe to share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motiondb::core {

// One edge: `count` of the frames in the row's node were followed by one in `to`.
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
  // Sum of the counts that leave a node; 0 for a node that only ends clips.
  std::int64_t row_sum(int from) const { return row_sums_[from]; }
  std::int32_t count(int from, int to) const;
  // Eq. 6; 0 where never seen. O(log of the row's length).
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

// Counts the transitions of a node sequence (one node a frame) between successive frames. Runs of
// different clips are given apart, so that none is counted across clips.
TransitionGraph CountTransitions(std::span<const std::vector<std::int32_t>> sequences,
                                 int node_count);

// The graph with the counts of both, which have as many nodes.
TransitionGraph Together(const TransitionGraph& a, const TransitionGraph& b);

// A clip's graph on the few nodes that it visits. Its states are numbered in order of node.
struct ClipGraph {
  std::vector<std::int32_t> nodes;   // state -> node of the layer, ascending
  std::vector<std::int32_t> frames;  // frames that the clip spends in each
  TransitionGraph transitions;       // between states
};

ClipGraph CountClipTransitions(std::span<const std::int32_t> sequence);

}  // namespace motiondb::core
