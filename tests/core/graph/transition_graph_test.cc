#include "core/graph/transition_graph.h"

#include <catch2/catch.hpp>
#include <map>
#include <random>

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

}  // namespace motiondb::tests::transition_graph_test
