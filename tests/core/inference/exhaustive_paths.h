// Reference for node paths: enumeration of all paths through a lattice.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/inference/lattice.h"

namespace motiondb::tests {

inline double LogTransition(const core::TransitionGraph& graph, int from, int to, double floor) {
  const double seen = graph.probability(from, to);
  return std::log(seen > 0 ? seen : floor);
}

// Returns all paths with a probability above 0, most probable first.
inline std::vector<core::NodePath> AllPaths(const core::Lattice& lattice,
                                            const core::TransitionGraph& graph, double floor) {
  std::vector<core::NodePath> paths{{}};
  for (const core::LatticeFrame& frame : lattice) {
    std::vector<core::NodePath> longer;
    for (const core::NodePath& path : paths) {
      for (std::size_t j = 0; j < frame.nodes.size(); ++j) {
        core::NodePath next = path;
        next.log_probability += frame.log_emission[static_cast<Eigen::Index>(j)];
        if (!path.nodes.empty()) {
          next.log_probability += LogTransition(graph, path.nodes.back(), frame.nodes[j], floor);
        }
        next.nodes.push_back(frame.nodes[j]);
        if (std::isfinite(next.log_probability)) longer.push_back(std::move(next));
      }
    }
    paths = std::move(longer);
  }
  std::stable_sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
    return a.log_probability > b.log_probability;
  });
  return paths;
}

// Returns the best path by the textbook Viterbi algorithm over all nodes of a layer.
inline core::NodePath Viterbi(const core::Lattice& lattice, const core::TransitionGraph& graph,
                              double floor) {
  std::vector<std::vector<double>> best(lattice.size());
  std::vector<std::vector<int>> from(lattice.size());
  for (std::size_t t = 0; t < lattice.size(); ++t) {
    for (std::size_t j = 0; j < lattice[t].nodes.size(); ++j) {
      double score = t == 0 ? 0 : -std::numeric_limits<double>::infinity();
      int source = -1;
      for (std::size_t i = 0; t > 0 && i < lattice[t - 1].nodes.size(); ++i) {
        const double through = best[t - 1][i] + LogTransition(graph, lattice[t - 1].nodes[i],
                                                              lattice[t].nodes[j], floor);
        if (through > score) {
          score = through;
          source = static_cast<int>(i);
        }
      }
      best[t].push_back(score + lattice[t].log_emission[static_cast<Eigen::Index>(j)]);
      from[t].push_back(source);
    }
  }
  core::NodePath path;
  path.nodes.resize(lattice.size());
  auto at = static_cast<int>(std::max_element(best.back().begin(), best.back().end()) -
                             best.back().begin());
  path.log_probability = best.back()[at];
  for (std::size_t t = lattice.size(); t-- > 0;) {
    path.nodes[t] = lattice[t].nodes[at];
    at = from[t][at];
  }
  return path;
}

}  // namespace motiondb::tests
