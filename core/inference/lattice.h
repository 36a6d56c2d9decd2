// A lattice: for each observed frame the nodes that may explain it, and what can be asked of it
// under a transition graph. The beam search, exact Viterbi and the k best paths are all questions
// to one.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

// The candidates of one frame: nodes in ascending order, and log P_s(node | frame) of each (eq. 8).
struct LatticeFrame {
  std::vector<std::int32_t> nodes;
  Eigen::VectorXd log_emission;
};

// A node, and how probable it is that the motion is there.
struct NodeState {
  int node = 0;
  double probability = 0;
};

using Lattice = std::vector<LatticeFrame>;

struct NodePath {
  std::vector<std::int32_t> nodes;  // one a frame
  double log_probability = 0;       // eq. 7, natural logarithm
};

// The best `count` paths, in descending order, by dynamic programming that keeps `count` paths to
// each candidate. Fewer where fewer have a probability above 0. Ties go to the smaller node.
// O(frames * candidates^2 * count). Once cancelled this and the functions below return early, with
// what is of no use.
std::vector<NodePath> BestPaths(const Lattice& lattice, const TransitionGraph& graph,
                                double transition_floor, int count,
                                const Cancelled& cancelled = {});

// For each frame and candidate, the log probability of the best path through it; -infinity where
// there is none. O(frames * candidates^2).
std::vector<Eigen::VectorXd> MaxMarginals(const Lattice& lattice, const TransitionGraph& graph,
                                          double transition_floor, const Cancelled& cancelled = {});

// P(node at the last frame | observation), summed over all paths: one number a candidate of the
// last frame, zeros where no path exists. O(frames * candidates^2).
Eigen::VectorXd LastNodeDistribution(const Lattice& lattice, const TransitionGraph& graph,
                                     double transition_floor, const Cancelled& cancelled = {});

// Turns log densities into log P_s(k | x) with P(k) uniform: eq. 8 over these candidates.
void NormalizeEmission(Eigen::VectorXd& log_emission);

// Sums of probabilities that are kept as logarithms. Pure.

// log of the sum of exp(logs), which are not empty; -infinity where all are.
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
