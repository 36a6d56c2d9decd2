#include "core/graph/transition_graph.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "core/motion/execution.h"

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

namespace {

constexpr double kLogZero = -std::numeric_limits<double>::infinity();
constexpr double kRoundedAway = 1e-17;  // less than half an ulp of 1

// Log emissions relative to the maximum. Below kNegligibleEmission, a node's share is negligible
// next to what the floor transfers to the most likely node, unless the floor is extremely small.
constexpr double kNegligibleEmission = -600;
constexpr double kMinUsefulFloor = 1e-100;
constexpr Eigen::Index kBlockNodes = 8;  // nodes of a block: neighbours are similar

// Steps for one observed frame.
std::int64_t StepsOf(const TransitionGraph& graph,
                     const Eigen::Ref<const EmissionMatrix>& emission) {
  return emission.cols() + graph.edge_count();
}

// log(e^a + e^b).
double LogAdd(double a, double b) {
  const double high = std::max(a, b);
  return high == kLogZero ? kLogZero : high + std::log1p(std::exp(std::min(a, b) - high));
}

// Multiplies `forward` by exp(emission - peak). Sets blocks of nodes to 0 if all their emissions
// are negligible: most nodes of a large layer are, and exponentials dominate the cost.
void Weigh(const Eigen::Ref<const Eigen::RowVectorXd>& emission, double peak,
           double negligible_emission, Eigen::VectorXd& forward) {
  const Eigen::Index nodes = forward.size();
  const Eigen::Index whole = nodes / kBlockNodes * kBlockNodes;
  for (Eigen::Index n = 0; n < whole; n += kBlockNodes) {
    auto part = forward.segment<kBlockNodes>(n).array();
    const auto relative = emission.segment<kBlockNodes>(n).transpose().array() - peak;
    if (relative.maxCoeff() < negligible_emission) {
      part.setZero();
    } else {
      part *= relative.exp();
    }
  }
  const Eigen::Index rest = nodes - whole;
  forward.tail(rest).array() *= (emission.tail(rest).transpose().array() - peak).exp();
}

// The strict rule (floor 0), entirely in logarithms: slower, but no path underflows. `forward`
// becomes the log probabilities at the last frame.
double LogGenerationOfSeen(const TransitionGraph& graph,
                           const Eigen::Ref<const EmissionMatrix>& emission,
                           Eigen::VectorXd& forward, ThrottledCancellation& cancellation) {
  forward = emission.row(0).transpose();
  for (Eigen::Index t = 1; t < emission.rows(); ++t) {
    if (cancellation.cancelled(StepsOf(graph, emission))) return kLogZero;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(emission.cols(), kLogZero);
    for (int from = 0; from < static_cast<int>(emission.cols()); ++from) {
      const double log_leaving = std::log(static_cast<double>(graph.row_sum(from)));
      for (const Edge& edge : graph.row(from)) {
        arriving[edge.to] =
            LogAdd(arriving[edge.to], forward[from] + std::log(edge.count) - log_leaving);
      }
    }
    forward = arriving + emission.row(t).transpose();
  }
  double sum = kLogZero;
  for (double log : forward) sum = LogAdd(sum, log);
  return sum;
}

}  // namespace

double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  const Eigen::Index nodes = emission.cols();
  Eigen::VectorXd forward = Eigen::VectorXd::Ones(nodes);  // scaled to sum to 1 after each frame
  Eigen::VectorXd arriving(nodes);
  double log_probability = 0;
  if (last != nullptr) *last = Eigen::VectorXd::Zero(nodes);
  if (transition_floor == 0 && emission.rows() > 0) {
    log_probability = LogGenerationOfSeen(graph, emission, forward, cancellation);
    if (last != nullptr && log_probability > kLogZero) {
      *last = (forward.array() - log_probability).exp();
    }
    return log_probability;
  }

  // A smaller probability of a node vanishes by rounding where it arrives, next to the floor.
  const double negligible = kRoundedAway * transition_floor;
  const double negligible_emission =
      transition_floor < kMinUsefulFloor ? kLogZero : kNegligibleEmission;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    if (cancellation.cancelled(StepsOf(graph, emission))) return kLogZero;
    if (t > 0) {
      // Every pair has the floor; counted transitions replace it.
      arriving.setConstant(transition_floor * forward.sum());
      for (Eigen::Index from = 0; from < nodes; ++from) {
        if (forward[from] < negligible) continue;
        const auto leaving = static_cast<double>(graph.row_sum(static_cast<int>(from)));
        for (const Edge& edge : graph.row(static_cast<int>(from))) {
          arriving[edge.to] += forward[from] * (edge.count / leaving - transition_floor);
        }
      }
      forward = arriving.cwiseMax(0);
    }
    const double peak = emission.row(t).maxCoeff();
    if (!(peak > kLogZero)) return kLogZero;
    Weigh(emission.row(t), peak, negligible_emission, forward);
    const double sum = forward.sum();
    if (!(sum > 0)) return kLogZero;
    forward /= sum;
    log_probability += std::log(sum) + peak;
  }
  if (last != nullptr) *last = forward;
  return log_probability;
}

double LogGenerationOfCandidates(const TransitionGraph& graph,
                                 std::span<const std::vector<LikelyNode>> frames, double floor,
                                 std::vector<double>& scratch) {
  std::vector<double> previous;  // probabilities of the previous frame's nodes, sum 1
  std::vector<double> forward;
  double log_probability = 0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    // Counted transitions, minus the floor that every pair has.
    for (std::size_t i = 0; i < previous.size(); ++i) {
      const int from = frames[t - 1][i].node;
      const double share = previous[i] / static_cast<double>(graph.row_sum(from));
      for (const Edge& edge : graph.row(from)) {
        scratch[edge.to] += share * edge.count - previous[i] * floor;
      }
    }
    double peak = kLogZero;
    for (const LikelyNode& likely : frames[t]) peak = std::max<double>(peak, likely.log_density);
    forward.clear();
    double sum = 0;
    for (const LikelyNode& likely : frames[t]) {
      const double arriving = t == 0 ? 1 : std::max(0.0, floor + scratch[likely.node]);
      forward.push_back(arriving * std::exp(likely.log_density - peak));
      sum += forward.back();
    }
    for (double& probability : forward) probability /= sum;
    log_probability += std::log(sum) + peak;
    for (std::size_t i = 0; i < previous.size(); ++i) {
      for (const Edge& edge : graph.row(frames[t - 1][i].node)) scratch[edge.to] = 0;
    }
    previous.swap(forward);
  }
  return log_probability;
}

}  // namespace motiondb::core
