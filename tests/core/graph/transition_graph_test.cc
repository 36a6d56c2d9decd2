#include "core/graph/transition_graph.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace motiondb::tests::transition_graph_test {
namespace {

std::vector<std::vector<std::int32_t>> RandomSequences(int nodes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<std::int32_t>> sequences(6);
  for (auto& sequence : sequences) {
    const int length = 1 + static_cast<int>(random() % 40);
    for (int i = 0; i < length; ++i) {
      sequence.push_back(static_cast<std::int32_t>(random() % static_cast<unsigned>(nodes)));
    }
  }
  return sequences;
}

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

TEST_CASE("TransitionGraph: counts successive frames of one clip, never across clips",
          "[core][graph]") {
  const auto sequences = RandomSequences(7, 1);
  std::map<std::pair<int, int>, int> counted;
  for (const auto& sequence : sequences) {
    for (std::size_t i = 1; i < sequence.size(); ++i) ++counted[{sequence[i - 1], sequence[i]}];
  }
  const core::TransitionGraph graph = core::CountTransitions(sequences, 7);
  int edges = 0;
  for (int from = 0; from < 7; ++from) {
    for (int to = 0; to < 7; ++to) {
      const auto it = counted.find({from, to});
      CHECK(graph.count(from, to) == (it == counted.end() ? 0 : it->second));
      edges += it != counted.end();
    }
  }
  CHECK(graph.edge_count() == edges);
}

TEST_CASE("TransitionGraph: probabilities of a row with counts sum to 1", "[core][graph]") {
  const core::TransitionGraph graph = core::CountTransitions(RandomSequences(9, 2), 12);
  for (int from = 0; from < 12; ++from) {
    double sum = 0;
    for (int to = 0; to < 12; ++to) sum += graph.probability(from, to);
    CHECK(sum == Approx(graph.row_sum(from) > 0 ? 1 : 0));
  }
}

TEST_CASE("ClipGraph: only the clip's nodes, with frames and transitions", "[core][graph]") {
  const std::vector<std::int32_t> sequence{8, 8, 3, 8, 5, 5, 5};
  const core::ClipGraph graph = core::CountClipTransitions(sequence);
  CHECK(graph.nodes == std::vector<std::int32_t>{3, 5, 8});
  CHECK(graph.frames == std::vector<std::int32_t>{1, 3, 3});
  CHECK(graph.transitions.count(2, 2) == 1);
  CHECK(graph.transitions.count(2, 0) == 1);
  CHECK(graph.transitions.count(0, 2) == 1);
  CHECK(graph.transitions.count(2, 1) == 1);
  CHECK(graph.transitions.count(1, 1) == 2);
  CHECK(graph.transitions.edge_count() == 5);
}

TEST_CASE("LogGeneration: the strict path counts, however probable forbidden nodes are",
          "[core][graph]") {
  const std::vector<std::vector<std::int32_t>> sequences{{0, 0, 0}, {1, 1, 1}};
  const auto graph = core::CountTransitions(sequences, 2);
  core::EmissionMatrix emission(3, 2);
  emission << 0, -5000, -5000, 0, 0, -5000;  // each frame is nearest to the forbidden node
  Eigen::VectorXd last;
  CHECK(core::LogGeneration(graph, emission, 0, &last) == Approx(-5000));
  CHECK(last[0] == Approx(1));

  // The first frame is most probable in a node without transitions.
  const auto dead_end =
      core::CountTransitions(std::vector<std::vector<std::int32_t>>{{0}, {1, 1}}, 2);
  emission.col(0).setZero();
  emission.col(1).setConstant(-2000);
  CHECK(core::LogGeneration(dead_end, emission, 0, &last) == Approx(-6000));
  CHECK(last[1] == Approx(1));
}

TEST_CASE("LogGeneration: equals the sum over all paths", "[core][graph]") {
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    const int nodes = 2 + trial % 4;
    const int frames = 1 + trial % 5;
    const double floor = trial % 3 == 0 ? 0 : trial % 3 == 1 ? 1e-6 : 0.3;
    const auto graph =
        core::CountTransitions(RandomSequences(nodes, static_cast<unsigned>(trial)), nodes);
    core::EmissionMatrix emission(frames, nodes);
    for (Eigen::Index i = 0; i < emission.size(); ++i) {
      emission.data()[i] = -300 + std::normal_distribution<double>(0, 3)(random);
    }
    int paths = 1;
    for (int t = 0; t < frames; ++t) paths *= nodes;
    double sum = 0;
    std::vector<double> last(nodes, 0);
    for (int p = 0; p < paths; ++p) {
      double product = 1;
      int before = 0;
      for (int t = 0, code = p; t < frames; ++t, code /= nodes) {
        const int node = code % nodes;
        if (t > 0) {
          const double seen = graph.probability(before, node);
          product *= seen > 0 ? seen : floor;
        }
        product *= std::exp(emission(t, node) + 300);
        before = node;
      }
      sum += product;
      last[before] += product;
    }
    Eigen::VectorXd distribution;
    const double log = core::LogGeneration(graph, emission, floor, &distribution);
    CAPTURE(nodes, frames, floor);
    if (sum == 0) {
      CHECK(log == -std::numeric_limits<double>::infinity());
      CHECK(distribution == Eigen::VectorXd::Zero(nodes));
      continue;
    }
    CHECK(log == Approx(std::log(sum) - 300.0 * frames));
    for (int n = 0; n < nodes; ++n) CHECK(distribution[n] == Approx(last[n] / sum).margin(1e-12));
  }
}

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

}  // namespace motiondb::tests::transition_graph_test
