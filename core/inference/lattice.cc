#include "core/inference/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/execution.h"

namespace motiondb::core {
namespace {

constexpr double kLogZero = -std::numeric_limits<double>::infinity();
constexpr Eigen::Index kMaxTableCells = 1 << 20;  // candidates of one frame times those of the next

// log P_t between the candidates of successive frames. Nodes recur from frame to frame, so each
// node's row of the graph is expanded once, into a dense table.
class LogTransitions {
 public:
  // `lattice` and `graph` must outlive this object.
  LogTransitions(const Lattice& lattice, const TransitionGraph& graph, double log_floor)
      : graph_(graph),
        log_floor_(log_floor),
        place_of_node_(static_cast<std::size_t>(graph.node_count()), -1),
        places_(lattice.size()) {
    for (std::size_t t = 0; t < lattice.size(); ++t) {
      for (const std::int32_t node : lattice[t].nodes) {
        std::int32_t& place = place_of_node_[node];
        if (place < 0) {
          place = static_cast<std::int32_t>(nodes_.size());
          nodes_.push_back(node);
        }
        places_[t].push_back(place);
      }
    }
    keeps_rows_ = nodes_.size() <= kMaxKeptRows;
    const auto count = static_cast<Eigen::Index>(nodes_.size());
    rows_.resize(keeps_rows_ ? count : 1, count);
    is_known_.resize(nodes_.size(), false);
  }

  // Returns log P_t from candidate i of frame t to each candidate of the next frame. Valid until
  // the next call.
  const Eigen::VectorXd& From(std::size_t t, Eigen::Index i) {
    const std::vector<std::int32_t>& to = places_[t + 1];
    const double* const row = Row(places_[t][static_cast<std::size_t>(i)]);
    log_transition_.resize(static_cast<Eigen::Index>(to.size()));
    for (std::size_t j = 0; j < to.size(); ++j) {
      log_transition_[static_cast<Eigen::Index>(j)] = row[to[j]];
    }
    return log_transition_;
  }

 private:
  // With more nodes, as in the exact search on a large layer, rows are not kept.
  static constexpr std::size_t kMaxKeptRows = 512;

  const double* Row(std::int32_t place) {
    auto row = rows_.row(keeps_rows_ ? place : 0);
    if (is_known_[place]) return row.data();
    is_known_[place] = keeps_rows_;
    row.setConstant(log_floor_);
    const std::int32_t from = nodes_[place];
    const double log_leaving = std::log(static_cast<double>(graph_.row_sum(from)));
    for (const Edge& edge : graph_.row(from)) {
      const std::int32_t to = place_of_node_[edge.to];
      if (to >= 0) row[to] = std::log(edge.count) - log_leaving;
    }
    return row.data();
  }

  const TransitionGraph& graph_;
  const double log_floor_;
  std::vector<std::int32_t> place_of_node_;        // index in nodes_; -1: not in the lattice
  std::vector<std::int32_t> nodes_;                // in order of first appearance
  std::vector<std::vector<std::int32_t>> places_;  // of each frame's candidates
  bool keeps_rows_ = false;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_;
  std::vector<bool> is_known_;  // rows
  Eigen::VectorXd log_transition_;
};

// One step of a path that ends at a candidate.
struct Step {
  double score = kLogZero;
  std::int32_t from = -1;  // candidate of the previous frame
  std::int32_t rank = -1;  // index of that candidate's path
};

// Origins of the steps of one frame, for backtracking: packed in four bytes for each candidate and
// rank.
class StepOrigins {
 public:
  explicit StepOrigins(const std::vector<std::vector<Step>>& steps) {
    for (const std::vector<Step>& best : steps) width_ = std::max(width_, best.size());
    packed_.resize(width_ * steps.size());
    for (std::size_t j = 0; j < steps.size(); ++j) {
      for (std::size_t rank = 0; rank < steps[j].size(); ++rank) {
        packed_[j * width_ + rank] = static_cast<std::uint32_t>(steps[j][rank].from) * kRanks +
                                     static_cast<std::uint32_t>(steps[j][rank].rank);
      }
    }
  }
  // Returns the candidate of the previous frame and the index of its path.
  Step Before(const Step& at) const {
    const std::uint32_t packed =
        packed_[static_cast<std::size_t>(at.from) * width_ + static_cast<std::size_t>(at.rank)];
    return {.from = static_cast<std::int32_t>(packed / kRanks),
            .rank = static_cast<std::int32_t>(packed % kRanks)};
  }

 private:
  static constexpr std::uint32_t kRanks = 128;  // a search keeps at most 100 paths

  std::size_t width_ = 0;
  std::vector<std::uint32_t> packed_;
};

// Inserts a step into the best `count` steps, best first; ties keep insertion order.
void Insert(std::vector<Step>& best, const Step& step, int count) {
  if (static_cast<int>(best.size()) == count) {
    if (step.score <= best.back().score) return;
    best.pop_back();
  }
  const auto at = std::upper_bound(best.begin(), best.end(), step,
                                   [](const Step& a, const Step& b) { return a.score > b.score; });
  best.insert(at, step);
}

// Returns the best scores of paths from the first frame to each candidate, including its emission.
std::vector<Eigen::VectorXd> ForwardMax(const Lattice& lattice, LogTransitions& log_transitions,
                                        ThrottledCancellation& cancellation) {
  std::vector<Eigen::VectorXd> best(lattice.size());
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    best[t] = lattice[t].log_emission;
    if (t == 0) continue;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(best[t].size(), kLogZero);
    for (Eigen::Index i = 0; i < best[t - 1].size(); ++i) {
      if (best[t - 1][i] == kLogZero) continue;
      if (cancellation.cancelled(arriving.size())) return best;
      const Eigen::VectorXd& log_transition = log_transitions.From(t - 1, i);
      arriving = arriving.cwiseMax((log_transition.array() + best[t - 1][i]).matrix());
    }
    best[t] += arriving;
  }
  return best;
}

// Returns the log of the summed probability that arrives at each candidate of frame t from the
// previous frame.
Eigen::VectorXd ArrivingSums(std::size_t t, const Eigen::VectorXd& forward, Eigen::Index candidates,
                             LogTransitions& log_transitions, ThrottledCancellation& cancellation) {
  Eigen::VectorXd arriving(candidates);
  if (candidates * forward.size() <= kMaxTableCells) {
    Eigen::MatrixXd through(candidates, forward.size());
    for (Eigen::Index i = 0; i < forward.size(); ++i) {
      through.col(i) = log_transitions.From(t - 1, i).array() + forward[i];
    }
    for (Eigen::Index j = 0; j < candidates; ++j) arriving[j] = LogSum(through.row(j));
    return arriving;
  }
  // The table would be much larger than the lattice, so compute each column twice instead.
  Eigen::ArrayXd peak = Eigen::ArrayXd::Constant(candidates, kLogZero);
  for (Eigen::Index i = 0; i < forward.size(); ++i) {
    if (cancellation.cancelled(candidates)) return arriving;
    peak = peak.max(log_transitions.From(t - 1, i).array() + forward[i]);
  }
  const Eigen::ArrayXd base = (peak == kLogZero).select(0.0, peak);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(candidates);
  for (Eigen::Index i = 0; i < forward.size(); ++i) {
    if (cancellation.cancelled(candidates)) return arriving;
    sum += (log_transitions.From(t - 1, i).array() + forward[i] - base).exp();
  }
  return base + sum.log();
}

}  // namespace

std::vector<NodePath> BestPaths(const Lattice& lattice, const TransitionGraph& graph,
                                double transition_floor, int count, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  std::vector<std::vector<Step>> before;  // [candidate][rank], previous and current frame
  std::vector<std::vector<Step>> steps;
  std::vector<StepOrigins> origins;  // of each frame but the first
  origins.reserve(lattice.size());
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    const LatticeFrame& frame = lattice[t];
    before.swap(steps);
    steps.assign(frame.nodes.size(), {});
    if (t == 0) {
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        steps[j].push_back({.score = frame.log_emission[static_cast<Eigen::Index>(j)]});
      }
      continue;
    }
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i].empty()) continue;
      if (cancellation.cancelled(std::ssize(frame.nodes) * std::ssize(before[i]))) return {};
      const Eigen::VectorXd& log_transition =
          log_transitions.From(t - 1, static_cast<Eigen::Index>(i));
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        const auto at = static_cast<Eigen::Index>(j);
        const double step = log_transition[at] + frame.log_emission[at];
        if (step == kLogZero) continue;
        for (std::size_t rank = 0; rank < before[i].size(); ++rank) {
          Insert(steps[j],
                 {before[i][rank].score + step, static_cast<std::int32_t>(i),
                  static_cast<std::int32_t>(rank)},
                 count);
        }
      }
    }
    origins.emplace_back(steps);
  }

  std::vector<Step> ends;
  for (std::size_t j = 0; j < steps.size(); ++j) {
    for (std::size_t rank = 0; rank < steps[j].size(); ++rank) {
      Insert(ends,
             {steps[j][rank].score, static_cast<std::int32_t>(j), static_cast<std::int32_t>(rank)},
             count);
    }
  }
  std::vector<NodePath> paths;
  for (Step at : ends) {
    if (at.score == kLogZero) break;
    NodePath& path = paths.emplace_back();
    path.log_probability = at.score;
    path.nodes.resize(lattice.size());
    for (std::size_t t = lattice.size(); t-- > 0;) {
      path.nodes[t] = lattice[t].nodes[at.from];
      if (t > 0) at = origins[t - 1].Before(at);
    }
  }
  return paths;
}

std::vector<Eigen::VectorXd> MaxMarginals(const Lattice& lattice, const TransitionGraph& graph,
                                          double transition_floor, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  std::vector<Eigen::VectorXd> marginals = ForwardMax(lattice, log_transitions, cancellation);
  if (lattice.empty() || cancellation.cancelled(0)) return marginals;
  Eigen::VectorXd ahead = Eigen::VectorXd::Zero(marginals.back().size());
  for (std::size_t t = lattice.size() - 1; t-- > 0;) {
    const Eigen::VectorXd from_next = ahead + lattice[t + 1].log_emission;
    ahead.resize(marginals[t].size());
    for (Eigen::Index i = 0; i < ahead.size(); ++i) {
      if (cancellation.cancelled(from_next.size())) return marginals;
      ahead[i] = (log_transitions.From(t, i) + from_next).maxCoeff();
    }
    marginals[t] += ahead;
  }
  return marginals;
}

Eigen::VectorXd LastNodeDistribution(const Lattice& lattice, const TransitionGraph& graph,
                                     double transition_floor, const Cancelled& cancelled) {
  // In logarithms throughout: under the strict rule a path may underflow at one frame and be the
  // only path left at the next.
  ThrottledCancellation cancellation(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  Eigen::VectorXd forward;
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    const Eigen::VectorXd& emission = lattice[t].log_emission;
    if (cancellation.cancelled(emission.size() * emission.size())) {
      return Eigen::VectorXd::Zero(lattice.back().log_emission.size());
    }
    if (t == 0) {
      forward = emission;
    } else {
      forward = ArrivingSums(t, forward, emission.size(), log_transitions, cancellation) + emission;
    }
  }
  const double sum = LogSum(forward);
  if (sum == kLogZero) return Eigen::VectorXd::Zero(forward.size());
  return (forward.array() - sum).exp();
}

void NormalizeEmission(Eigen::VectorXd& log_emission) {
  log_emission.array() -= LogSum(log_emission);
}

}  // namespace motiondb::core
