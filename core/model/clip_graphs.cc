#include "core/model/clip_graphs.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/model/label_units.h"

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

// Returns the sum of the clips' graphs.
TransitionGraph SumOnBottom(const Tree& tree, std::span<const ClipGraph* const> clips) {
  const int nodes = tree.node_count(tree.layer_count());
  std::vector<std::size_t> place(static_cast<std::size_t>(nodes) + 1);
  for (const ClipGraph* clip : clips) {
    for (std::size_t s = 0; s < clip->nodes.size(); ++s) {
      place[clip->nodes[s] + 1] += clip->transitions.row(static_cast<int>(s)).size();
    }
  }
  std::partial_sum(place.begin(), place.end(), place.begin());
  std::vector<Edge> of_clips(place.back());
  for (const ClipGraph* clip : clips) {
    for (std::size_t s = 0; s < clip->nodes.size(); ++s) {
      std::size_t& next = place[clip->nodes[s]];
      for (const Edge& edge : clip->transitions.row(static_cast<int>(s))) {
        of_clips[next++] = {clip->nodes[edge.to], edge.count};
      }
    }
  }
  std::vector<std::int32_t> row_begin = {0};
  std::vector<Edge> edges;
  std::vector<Edge> row;
  for (int node = 0; node < nodes; ++node) {
    // The places have moved to the ends of their rows.
    const std::size_t begin = node == 0 ? 0 : place[node - 1];
    row.assign(of_clips.begin() + static_cast<std::ptrdiff_t>(begin),
               of_clips.begin() + static_cast<std::ptrdiff_t>(place[node]));
    MergeEqualEnds(row);
    edges.insert(edges.end(), row.begin(), row.end());
    row_begin.push_back(static_cast<std::int32_t>(edges.size()));
  }
  return TransitionGraph(std::move(row_begin), std::move(edges));
}

// Returns the graph of `layer`, computed from that of the layer below.
TransitionGraph GraphAbove(const Tree& tree, int layer, const TransitionGraph& below) {
  std::vector<std::int32_t> row_begin = {0};
  std::vector<Edge> edges;
  std::vector<Edge> row;
  for (int node = 0; node < tree.node_count(layer); ++node) {
    row.clear();
    const int first = tree.first_child(layer, node);
    for (int child = first; child < first + tree.child_count(layer, node); ++child) {
      for (const Edge& edge : below.row(child)) {
        row.push_back({tree.parent(layer + 1, edge.to), edge.count});
      }
    }
    MergeEqualEnds(row);
    edges.insert(edges.end(), row.begin(), row.end());
    row_begin.push_back(static_cast<std::int32_t>(edges.size()));
  }
  return TransitionGraph(std::move(row_begin), std::move(edges));
}

}  // namespace

ClipGraph CountClipGraph(const Tree& tree, const ModelClip& clip) {
  return CountClipTransitions(NodesOf(tree, tree.layer_count(), clip));
}

std::shared_ptr<const ClipGraph> UnitGraph(const Model& model, int layer, const LabelUnit& unit) {
  const ModelClip& clip = model.clips()[unit.clip];
  if (unit.frame_count == clip.frame_count) return model.clip_graph(layer, unit.clip);
  std::vector<std::int32_t> nodes;
  for (int f = unit.first_frame; f < unit.first_frame + unit.frame_count; ++f) {
    nodes.push_back(model.tree().node_of_frame(layer, f));
  }
  return std::make_shared<const ClipGraph>(CountClipTransitions(nodes));
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

std::vector<TransitionGraph> SumClipGraphs(const Tree& tree,
                                           std::span<const ClipGraph* const> clips) {
  const int layers = tree.layer_count();
  std::vector<TransitionGraph> graphs(static_cast<std::size_t>(layers));
  graphs.back() = SumOnBottom(tree, clips);
  for (int layer = layers - 1; layer >= 1; --layer) {
    graphs[layer - 1] = GraphAbove(tree, layer, graphs[layer]);
  }
  return graphs;
}

TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips) {
  std::vector<std::vector<std::int32_t>> sequences;
  for (const ModelClip& clip : clips) sequences.push_back(NodesOf(tree, layer, clip));
  return CountTransitions(sequences, tree.node_count(layer));
}

}  // namespace motiondb::core
