#include "core/model/clip_graphs.h"

#include <algorithm>
#include <utility>

namespace motiondb::core {
namespace {

std::vector<std::int32_t> NodesOf(const Tree& tree, int layer, const ModelClip& clip) {
  std::vector<std::int32_t> nodes;
  nodes.reserve(clip.frame_count);
  for (int f = 0; f < clip.frame_count; ++f) {
    nodes.push_back(tree.node_of_frame(layer, clip.first_frame + f));
  }
  return nodes;
}

// Sorts edges by their end and adds the counts of equal ends.
void MergeEqualEnds(std::vector<Edge>& row) {
  std::sort(row.begin(), row.end(), [](const Edge& a, const Edge& b) { return a.to < b.to; });
  std::size_t last = 0;
  for (std::size_t e = 1; e < row.size(); ++e) {
    if (row[e].to == row[last].to) {
      row[last].count += row[e].count;
    } else {
      row[++last] = row[e];
    }
  }
  if (!row.empty()) row.resize(last + 1);
}

}  // namespace

ClipGraph CountClipGraph(const Tree& tree, const ModelClip& clip) {
  return CountClipTransitions(NodesOf(tree, tree.layer_count(), clip));
}

std::vector<std::int32_t> NodesAbove(const Tree& tree, int layer,
                                     std::span<const std::int32_t> bottom_nodes) {
  std::vector<std::int32_t> above;
  above.reserve(bottom_nodes.size());
  for (const std::int32_t node : bottom_nodes) {
    const Branch& branch = tree.branches()[tree.branch(tree.layer_count(), node)];
    above.push_back(tree.node_of_frame(layer, tree.frame_order()[branch.begin]));
  }
  return above;
}

ClipGraph ClipGraphAbove(const Tree& tree, int layer, const ClipGraph& bottom) {
  const std::vector<std::int32_t> above = NodesAbove(tree, layer, bottom.nodes);
  ClipGraph graph;
  std::vector<std::int32_t> state_of;  // for each state of the bottom layer
  for (std::size_t s = 0; s < above.size(); ++s) {
    if (graph.nodes.empty() || graph.nodes.back() != above[s]) {
      graph.nodes.push_back(above[s]);
      graph.frames.push_back(0);
    }
    graph.frames.back() += bottom.frames[s];
    state_of.push_back(static_cast<std::int32_t>(graph.nodes.size()) - 1);
  }
  std::vector<std::int32_t> row_begin = {0};
  std::vector<Edge> edges;
  std::vector<Edge> row;
  for (std::size_t s = 0; s < above.size(); ++s) {
    for (const Edge& edge : bottom.transitions.row(static_cast<int>(s))) {
      row.push_back({state_of[edge.to], edge.count});
    }
    if (s + 1 < above.size() && above[s + 1] == above[s]) continue;
    MergeEqualEnds(row);
    edges.insert(edges.end(), row.begin(), row.end());
    row_begin.push_back(static_cast<std::int32_t>(edges.size()));
    row.clear();
  }
  graph.transitions = TransitionGraph(std::move(row_begin), std::move(edges));
  return graph;
}

TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips) {
  std::vector<std::vector<std::int32_t>> sequences;
  for (const ModelClip& clip : clips) sequences.push_back(NodesOf(tree, layer, clip));
  return CountTransitions(sequences, tree.node_count(layer));
}

}  // namespace motiondb::core
