#include "core/inference/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/cancellation.h"

namespace motiondb::core {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr Eigen::Index kMostThrough = 1 << 20;  // candidates of one frame times those of the next

// log P_t between the candidates of successive frames. The nodes of a lattice come again from frame
// to frame, so each one's row of the graph is read once, into a table of all nodes by all nodes.
class LogTransitions {
 public:
  // Both must outlive it.
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
    keeps_rows_ = nodes_.size() <= kMostKept;
    const auto count = static_cast<Eigen::Index>(nodes_.size());
    rows_.resize(keeps_rows_ ? count : 1, count);
    is_known_.resize(nodes_.size(), false);
  }

  // From candidate i of frame t to each of the next frame's. Valid until the next call.
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
  // Beyond it, as in the exact search on a large layer, rows are made when they are asked for.
  static constexpr std::size_t kMostKept = 512;

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
  std::vector<std::int32_t> place_of_node_;        // in nodes_; -1 where no frame has the node
  std::vector<std::int32_t> nodes_;                // in order of their coming
  std::vector<std::vector<std::int32_t>> places_;  // of each frame's candidates
  bool keeps_rows_ = false;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_;
  std::vector<bool> is_known_;  // rows
  Eigen::VectorXd log_transition_;
};

// One step of a path that ends at a candidate.
struct Step {
  double score = kNever;
  std::int32_t from = -1;  // candidate of the frame before
  std::int32_t rank = -1;  // which of its paths
};

// Where steps come from, which is all of a frame that is kept to its end: for each candidate room
// for as many paths as any of them has, of four bytes.
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
  // Candidate of the frame before, and which of its paths.
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

// Keeps the best `count` steps, best first; of equals those that came first.
void Insert(std::vector<Step>& best, const Step& step, int count) {
  if (static_cast<int>(best.size()) == count) {
    if (step.score <= best.back().score) return;
    best.pop_back();
  }
  const auto at = std::upper_bound(best.begin(), best.end(), step,
                                   [](const Step& a, const Step& b) { return a.score > b.score; });
  best.insert(at, step);
}

// Best scores of paths from the first frame up to each candidate, its emission included.
std::vector<Eigen::VectorXd> ForwardMax(const Lattice& lattice, LogTransitions& log_transitions,
                                        Patience& patience) {
  std::vector<Eigen::VectorXd> best(lattice.size());
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    best[t] = lattice[t].log_emission;
    if (t == 0) continue;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(best[t].size(), kNever);
    for (Eigen::Index i = 0; i < best[t - 1].size(); ++i) {
      if (best[t - 1][i] == kNever) continue;
      if (patience.IsOver(arriving.size())) return best;
      const Eigen::VectorXd& log_transition = log_transitions.From(t - 1, i);
      arriving = arriving.cwiseMax((log_transition.array() + best[t - 1][i]).matrix());
    }
    best[t] += arriving;
  }
  return best;
}

// log of what arrives at each candidate of frame t from those of the frame before, summed.
Eigen::VectorXd ArrivingSums(std::size_t t, const Eigen::VectorXd& forward, Eigen::Index candidates,
                             LogTransitions& log_transitions, Patience& patience) {
  Eigen::VectorXd arriving(candidates);
  if (candidates * forward.size() <= kMostThrough) {
    Eigen::MatrixXd through(candidates, forward.size());
    for (Eigen::Index i = 0; i < forward.size(); ++i) {
      through.col(i) = log_transitions.From(t - 1, i).array() + forward[i];
    }
    for (Eigen::Index j = 0; j < candidates; ++j) arriving[j] = LogSum(through.row(j));
    return arriving;
  }
  // The table would outgrow the lattice by far, so each of its columns is made twice.
  Eigen::ArrayXd peak = Eigen::ArrayXd::Constant(candidates, kNever);
  for (Eigen::Index i = 0; i < forward.size(); ++i) {
    if (patience.IsOver(candidates)) return arriving;
    peak = peak.max(log_transitions.From(t - 1, i).array() + forward[i]);
  }
  const Eigen::ArrayXd base = (peak == kNever).select(0.0, peak);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(candidates);
  for (Eigen::Index i = 0; i < forward.size(); ++i) {
    if (patience.IsOver(candidates)) return arriving;
    sum += (log_transitions.From(t - 1, i).array() + forward[i] - base).exp();
  }
  return base + sum.log();
}

}  // namespace

std::vector<NodePath> BestPaths(const Lattice& lattice, const TransitionGraph& graph,
                                double transition_floor, int count, const Cancelled& cancelled) {
  Patience patience(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  std::vector<std::vector<Step>> before;  // [candidate][rank], of the frame before and of this one
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
      if (patience.IsOver(std::ssize(frame.nodes) * std::ssize(before[i]))) return {};
      const Eigen::VectorXd& log_transition =
          log_transitions.From(t - 1, static_cast<Eigen::Index>(i));
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        const auto at = static_cast<Eigen::Index>(j);
        const double step = log_transition[at] + frame.log_emission[at];
        if (step == kNever) continue;
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
    if (at.score == kNever) break;
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
  Patience patience(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  std::vector<Eigen::VectorXd> marginals = ForwardMax(lattice, log_transitions, patience);
  if (lattice.empty() || patience.IsOver(0)) return marginals;
  Eigen::VectorXd ahead = Eigen::VectorXd::Zero(marginals.back().size());
  for (std::size_t t = lattice.size() - 1; t-- > 0;) {
    const Eigen::VectorXd from_next = ahead + lattice[t + 1].log_emission;
    ahead.resize(marginals[t].size());
    for (Eigen::Index i = 0; i < ahead.size(); ++i) {
      if (patience.IsOver(from_next.size())) return marginals;
      ahead[i] = (log_transitions.From(t, i) + from_next).maxCoeff();
    }
    marginals[t] += ahead;
  }
  return marginals;
}

Eigen::VectorXd LastNodeDistribution(const Lattice& lattice, const TransitionGraph& graph,
                                     double transition_floor, const Cancelled& cancelled) {
  // In logarithms throughout: under the strict rule a path may have no share that a double can hold
  // at one frame, and be the only one left at the next.
  Patience patience(cancelled);
  LogTransitions log_transitions(lattice, graph, std::log(transition_floor));
  Eigen::VectorXd forward;
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    const Eigen::VectorXd& emission = lattice[t].log_emission;
    if (patience.IsOver(emission.size() * emission.size())) {
      return Eigen::VectorXd::Zero(lattice.back().log_emission.size());
    }
    if (t == 0) {
      forward = emission;
    } else {
      forward = ArrivingSums(t, forward, emission.size(), log_transitions, patience) + emission;
    }
  }
  const double sum = LogSum(forward);
  if (sum == kNever) return Eigen::VectorXd::Zero(forward.size());
  return (forward.array() - sum).exp();
}

void NormalizeEmission(Eigen::VectorXd& log_emission) {
  log_emission.array() -= LogSum(log_emission);
}

}  // namespace motiondb::core
