#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/graph/transition_graph.h"

namespace motiondb::tests::generation_test {
namespace {

// The forward algorithm without optimization: all pairs of nodes, all exponentials.
double PlainLogGeneration(const core::TransitionGraph& graph, const core::EmissionMatrix& emission,
                          double floor) {
  const auto nodes = static_cast<int>(emission.cols());
  std::vector<double> forward(nodes, 1.0);
  double log_probability = 0;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    std::vector<double> arriving(nodes, t == 0 ? 1.0 : 0.0);
    for (int from = 0; t > 0 && from < nodes; ++from) {
      for (int to = 0; to < nodes; ++to) {
        const double seen = graph.probability(from, to);
        arriving[to] += forward[from] * (seen > 0 ? seen : floor);
      }
    }
    const double peak = emission.row(t).maxCoeff();
    double sum = 0;
    for (int n = 0; n < nodes; ++n) {
      forward[n] = arriving[n] * std::exp(emission(t, n) - peak);
      sum += forward[n];
    }
    for (double& probability : forward) probability /= sum;
    log_probability += std::log(sum) + peak;
  }
  return log_probability;
}

}  // namespace

TEST_CASE("LogGeneration: equals the plain sum, also with improbable nodes", "[core][graph]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  for (const int nodes : {1, 7, 8, 9, 30}) {
    std::vector<std::int32_t> path;
    for (int i = 0; i < 400; ++i) path.push_back(static_cast<int>(part(random) * nodes));
    const std::vector<std::vector<std::int32_t>> paths{path};
    const core::TransitionGraph graph = core::CountTransitions(paths, nodes);
    for (const double far : {10.0, 700.0, 5000.0}) {
      core::EmissionMatrix emission(12, nodes);
      for (Eigen::Index t = 0; t < emission.rows(); ++t) {
        for (int n = 0; n < nodes; ++n) {
          emission(t, n) = -far * (part(random) + std::abs(static_cast<double>(n) - 2.0 * t) / 10);
        }
      }
      for (const double floor : {1e-3, 1e-6, 1e-120}) {
        CAPTURE(nodes, far, floor);
        const double expected = PlainLogGeneration(graph, emission, floor);
        CHECK(core::LogGeneration(graph, emission, floor) == Approx(expected).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("LogGenerationOfCandidates: equals a sum with all other nodes impossible",
          "[core][graph]") {
  constexpr int kNodes = 30;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> part(0, 1);
  std::vector<std::int32_t> path;
  for (int i = 0; i < 400; ++i) path.push_back(static_cast<int>(part(random) * kNodes));
  const core::TransitionGraph graph =
      core::CountTransitions(std::vector<std::vector<std::int32_t>>{path}, kNodes);
  std::vector<double> scratch(kNodes, 0);
  for (const float share : {0.0F, 0.2F, 1.0F}) {  // of listed nodes, in addition to one
    std::vector<std::vector<core::LikelyNode>> frames(12);
    core::EmissionMatrix emission(12, kNodes);
    emission.setConstant(-std::numeric_limits<double>::infinity());
    for (int t = 0; t < 12; ++t) {
      for (int n = kNodes - 1; n >= 0; --n) {
        if (n != t && part(random) >= share) continue;
        frames[t].push_back({n, -50 * part(random)});
        emission(t, n) = frames[t].back().log_density;
      }
    }
    for (const double floor : {1e-3, 1e-6}) {
      const double expected = core::LogGeneration(graph, emission, floor);
      CHECK(core::LogGenerationOfCandidates(graph, frames, floor, scratch) ==
            Approx(expected).epsilon(1e-9));
      CHECK(scratch == std::vector<double>(kNodes, 0));
    }
  }
}

}  // namespace motiondb::tests::generation_test
