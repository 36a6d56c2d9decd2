#include "core/graph/transition_graph.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace motiondb::core {
namespace {

using Pair = std::pair<std::int32_t, std::int32_t>;

// Counting sort by one member; stable.
std::vector<Pair> SortedBy(std::int32_t Pair::*key, const std::vector<Pair>& pairs,
                           int node_count) {
  std::vector<std::int32_t> place(static_cast<std::size_t>(node_count) + 1, 0);
  for (const Pair& pair : pairs) ++place[pair.*key + 1];
  std::partial_sum(place.begin(), place.end(), place.begin());
  std::vector<Pair> sorted(pairs.size());
  for (const Pair& pair : pairs) sorted[place[pair.*key]++] = pair;
  return sorted;
}

// Counts transitions (from, to), in any order. O(pairs + nodes).
TransitionGraph FromPairs(std::vector<Pair> pairs, int node_count) {
  pairs = SortedBy(&Pair::second, pairs, node_count);
  pairs = SortedBy(&Pair::first, pairs, node_count);
  std::vector<std::int32_t> row_begin(static_cast<std::size_t>(node_count) + 1, 0);
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i > 0 && pairs[i] == pairs[i - 1]) {
      ++edges.back().count;
      continue;
    }
    edges.push_back({pairs[i].second, 1});
    ++row_begin[pairs[i].first + 1];
  }
  for (int k = 0; k < node_count; ++k) row_begin[k + 1] += row_begin[k];
  return TransitionGraph(std::move(row_begin), std::move(edges));
}

}  // namespace

TransitionGraph::TransitionGraph(std::vector<std::int32_t> row_begin, std::vector<Edge> edges)
    : row_begin_(std::move(row_begin)), edges_(std::move(edges)), row_sums_(node_count()) {
  for (int from = 0; from < node_count(); ++from) {
    for (const Edge& edge : row(from)) row_sums_[from] += edge.count;
  }
}

std::int32_t TransitionGraph::count(int from, int to) const {
  const auto edges = row(from);
  const auto it = std::lower_bound(edges.begin(), edges.end(), to,
                                   [](const Edge& edge, int node) { return edge.to < node; });
  return it != edges.end() && it->to == to ? it->count : 0;
}

TransitionGraph CountTransitions(std::span<const std::vector<std::int32_t>> sequences,
                                 int node_count) {
  std::vector<Pair> pairs;
  for (const auto& sequence : sequences) {
    for (std::size_t i = 1; i < sequence.size(); ++i) {
      pairs.emplace_back(sequence[i - 1], sequence[i]);
    }
  }
  return FromPairs(std::move(pairs), node_count);
}

TransitionGraph MergeGraphs(const TransitionGraph& a, const TransitionGraph& b) {
  std::vector<std::int32_t> row_begin{0};
  std::vector<Edge> edges;
  edges.reserve(a.edges().size() + b.edges().size());
  for (int from = 0; from < a.node_count(); ++from) {
    const auto in_a = a.row(from);
    const auto in_b = b.row(from);
    auto i = in_a.begin();
    auto j = in_b.begin();
    while (i != in_a.end() || j != in_b.end()) {
      const bool from_a = j == in_b.end() || (i != in_a.end() && i->to <= j->to);
      const bool from_b = i == in_a.end() || (j != in_b.end() && j->to <= i->to);
      edges.push_back(from_a ? *i : *j);
      if (from_a && from_b) edges.back().count += j->count;
      if (from_a) ++i;
      if (from_b) ++j;
    }
    row_begin.push_back(static_cast<std::int32_t>(edges.size()));
  }
  edges.shrink_to_fit();
  return TransitionGraph(std::move(row_begin), std::move(edges));
}

ClipGraph CountClipTransitions(std::span<const std::int32_t> sequence) {
  ClipGraph graph;
  graph.nodes.assign(sequence.begin(), sequence.end());
  std::sort(graph.nodes.begin(), graph.nodes.end());
  graph.nodes.erase(std::unique(graph.nodes.begin(), graph.nodes.end()), graph.nodes.end());
  graph.frames.resize(graph.nodes.size());
  std::vector<std::int32_t> states;
  states.reserve(sequence.size());
  for (std::int32_t node : sequence) {
    const auto it = std::lower_bound(graph.nodes.begin(), graph.nodes.end(), node);
    states.push_back(static_cast<std::int32_t>(it - graph.nodes.begin()));
    ++graph.frames[states.back()];
  }
  graph.transitions = CountTransitions(std::span(&states, 1), static_cast<int>(graph.nodes.size()));
  return graph;
}

}  // namespace motiondb::core
