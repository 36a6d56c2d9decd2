// A lattice: the candidate nodes of each observed frame. Beam search, exact Viterbi, k best paths
// and posteriors are computed on it, with a transition graph.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/motion/execution.h"

namespace motiondb::core {

// The candidates of one frame: nodes in ascending order, and log P_s(node | frame) of each (eq. 8).
struct LatticeFrame {
  std::vector<std::int32_t> nodes;
  Eigen::VectorXd log_emission;
};

// A node and the probability that the motion is in it.
struct NodeState {
  int node = 0;
  double probability = 0;
};

using Lattice = std::vector<LatticeFrame>;

struct NodePath {
  std::vector<std::int32_t> nodes;  // one for each frame
  double log_probability = 0;       // eq. 7, natural logarithm
};

// Returns the best `count` paths, in descending order, by dynamic programming with `count` paths
// for each candidate. Fewer if fewer have a probability above 0. Ties: the smaller node first. Once
// cancelled, this and the functions below return early with undefined results. O(frames *
// candidates^2 * count).
std::vector<NodePath> BestPaths(const Lattice& lattice, const TransitionGraph& graph,
                                double transition_floor, int count,
                                const Cancelled& cancelled = {});

// Returns, for each frame and candidate, the log probability of the best path through it; -infinity
// if there is none. O(frames * candidates^2).
std::vector<Eigen::VectorXd> MaxMarginals(const Lattice& lattice, const TransitionGraph& graph,
                                          double transition_floor, const Cancelled& cancelled = {});

// Returns P(node at the last frame | observation), summed over all paths: one number for each
// candidate of the last frame, zeros if no path exists. O(frames * candidates^2).
Eigen::VectorXd LastNodeDistribution(const Lattice& lattice, const TransitionGraph& graph,
                                     double transition_floor, const Cancelled& cancelled = {});

// Converts log densities to log P_s(k | x) with uniform P(k): eq. 8 over these candidates.
void NormalizeEmission(Eigen::VectorXd& log_emission);

// Returns log(sum(exp(logs))); -infinity if all are. REQUIRES: logs is not empty.
template <typename Derived>
double LogSum(const Eigen::DenseBase<Derived>& logs) {
  const double peak = logs.maxCoeff();
  if (!std::isfinite(peak)) return peak;
  return peak + std::log((logs.derived().array() - peak).exp().sum());
}

inline double LogSum(const std::vector<double>& logs) {
  return LogSum(
      Eigen::Map<const Eigen::ArrayXd>(logs.data(), static_cast<Eigen::Index>(logs.size())));
}

}  // namespace motiondb::core
