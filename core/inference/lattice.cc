#include "core/inference/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/inference/log_sum.h"

namespace motiondb::core {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

// log P_t from one node to each of the candidates `to`, by one walk along the node's row and them.
void LogTransitions(const TransitionGraph& graph, std::int32_t from,
                    const std::vector<std::int32_t>& to, double log_floor,
                    Eigen::VectorXd& log_transition) {
  log_transition.setConstant(static_cast<Eigen::Index>(to.size()), log_floor);
  const double log_leaving = std::log(static_cast<double>(graph.row_sum(from)));
  const auto row = graph.row(from);
  auto edge = row.begin();
  for (std::size_t j = 0; j < to.size() && edge != row.end(); ++j) {
    edge = std::lower_bound(edge, row.end(), to[j],
                            [](const Edge& e, std::int32_t node) { return e.to < node; });
    if (edge != row.end() && edge->to == to[j]) {
      log_transition[static_cast<Eigen::Index>(j)] = std::log(edge->count) - log_leaving;
    }
  }
}

// One step of a path that ends at a candidate.
struct Step {
  double score = kNever;
  std::int32_t from = -1;  // candidate of the frame before
  std::int32_t rank = -1;  // which of its paths
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
std::vector<Eigen::VectorXd> ForwardMax(const Lattice& lattice, const TransitionGraph& graph,
                                        double log_floor) {
  std::vector<Eigen::VectorXd> best(lattice.size());
  Eigen::VectorXd log_transition;
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    best[t] = lattice[t].log_emission;
    if (t == 0) continue;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(best[t].size(), kNever);
    for (Eigen::Index i = 0; i < best[t - 1].size(); ++i) {
      if (best[t - 1][i] == kNever) continue;
      LogTransitions(graph, lattice[t - 1].nodes[i], lattice[t].nodes, log_floor, log_transition);
      arriving = arriving.cwiseMax((log_transition.array() + best[t - 1][i]).matrix());
    }
    best[t] += arriving;
  }
  return best;
}

}  // namespace

std::vector<NodePath> BestPaths(const Lattice& lattice, const TransitionGraph& graph,
                                double transition_floor, int count) {
  const double log_floor = std::log(transition_floor);
  std::vector<std::vector<std::vector<Step>>> steps(lattice.size());  // [frame][candidate][rank]
  Eigen::VectorXd log_transition;
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    const LatticeFrame& frame = lattice[t];
    steps[t].resize(frame.nodes.size());
    if (t == 0) {
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        steps[0][j].push_back({.score = frame.log_emission[static_cast<Eigen::Index>(j)]});
      }
      continue;
    }
    for (std::size_t i = 0; i < steps[t - 1].size(); ++i) {
      if (steps[t - 1][i].empty()) continue;
      LogTransitions(graph, lattice[t - 1].nodes[i], frame.nodes, log_floor, log_transition);
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        const auto at = static_cast<Eigen::Index>(j);
        const double step = log_transition[at] + frame.log_emission[at];
        if (step == kNever) continue;
        for (std::size_t rank = 0; rank < steps[t - 1][i].size(); ++rank) {
          Insert(steps[t][j],
                 {steps[t - 1][i][rank].score + step, static_cast<std::int32_t>(i),
                  static_cast<std::int32_t>(rank)},
                 count);
        }
      }
    }
  }

  std::vector<Step> ends;
  if (!lattice.empty()) {
    for (std::size_t j = 0; j < steps.back().size(); ++j) {
      for (std::size_t rank = 0; rank < steps.back()[j].size(); ++rank) {
        Insert(ends,
               {steps.back()[j][rank].score, static_cast<std::int32_t>(j),
                static_cast<std::int32_t>(rank)},
               count);
      }
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
      at = steps[t][at.from][at.rank];
    }
  }
  return paths;
}

std::vector<Eigen::VectorXd> MaxMarginals(const Lattice& lattice, const TransitionGraph& graph,
                                          double transition_floor) {
  const double log_floor = std::log(transition_floor);
  std::vector<Eigen::VectorXd> marginals = ForwardMax(lattice, graph, log_floor);
  if (lattice.empty()) return marginals;
  Eigen::VectorXd log_transition;
  Eigen::VectorXd ahead = Eigen::VectorXd::Zero(marginals.back().size());
  for (std::size_t t = lattice.size() - 1; t-- > 0;) {
    const Eigen::VectorXd from_next = ahead + lattice[t + 1].log_emission;
    ahead.resize(marginals[t].size());
    for (Eigen::Index i = 0; i < ahead.size(); ++i) {
      LogTransitions(graph, lattice[t].nodes[i], lattice[t + 1].nodes, log_floor, log_transition);
      ahead[i] = (log_transition + from_next).maxCoeff();
    }
    marginals[t] += ahead;
  }
  return marginals;
}

Eigen::VectorXd LastNodeDistribution(const Lattice& lattice, const TransitionGraph& graph,
                                     double transition_floor) {
  // In logarithms throughout: under the strict rule a path may have no share that a double can hold
  // at one frame, and be the only one left at the next.
  const double log_floor = std::log(transition_floor);
  Eigen::VectorXd forward;
  Eigen::VectorXd log_transition;
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    Eigen::VectorXd arriving = Eigen::VectorXd::Zero(lattice[t].log_emission.size());
    if (t > 0) {
      Eigen::MatrixXd through(arriving.size(), forward.size());
      for (Eigen::Index i = 0; i < forward.size(); ++i) {
        LogTransitions(graph, lattice[t - 1].nodes[i], lattice[t].nodes, log_floor, log_transition);
        through.col(i) = log_transition.array() + forward[i];
      }
      for (Eigen::Index j = 0; j < arriving.size(); ++j) arriving[j] = LogSum(through.row(j));
    }
    forward = arriving + lattice[t].log_emission;
  }
  const double sum = LogSum(forward);
  if (sum == kNever) return Eigen::VectorXd::Zero(forward.size());
  return (forward.array() - sum).exp();
}

void NormalizeEmission(Eigen::VectorXd& log_emission) {
  log_emission.array() -= LogSum(log_emission);
}

}  // namespace motiondb::core
