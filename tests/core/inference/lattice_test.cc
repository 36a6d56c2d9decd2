#include "core/inference/lattice.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/core/inference/exhaustive_paths.h"

namespace motiondb::tests::lattice_test {
namespace {

struct Case {
  core::Lattice lattice;
  core::TransitionGraph graph;
  double floor = 0;
};

// A random graph of up to 6 nodes and an observation of up to 5 frames; some candidates are
// omitted.
Case RandomCase(unsigned seed) {
  std::mt19937 random(seed);
  const int nodes = 2 + static_cast<int>(random() % 5);
  Case made;
  std::vector<std::vector<std::int32_t>> sequences(2);
  for (auto& sequence : sequences) {
    for (int i = 0; i < 15; ++i) {
      sequence.push_back(static_cast<std::int32_t>(random() % static_cast<unsigned>(nodes)));
    }
  }
  made.graph = core::CountTransitions(sequences, nodes);
  made.floor = seed % 3 == 0 ? 0 : seed % 3 == 1 ? 1e-6 : 0.2;
  std::normal_distribution<double> normal(0, 2);
  const int frames = 1 + static_cast<int>(random() % 5);
  for (int t = 0; t < frames; ++t) {
    core::LatticeFrame& frame = made.lattice.emplace_back();
    std::vector<double> log_emission;
    for (int n = 0; n < nodes; ++n) {
      if (random() % 4 == 0 && n > 0) continue;
      frame.nodes.push_back(n);
      log_emission.push_back(normal(random));
    }
    frame.log_emission = Eigen::Map<Eigen::VectorXd>(
        log_emission.data(), static_cast<Eigen::Index>(log_emission.size()));
    core::NormalizeEmission(frame.log_emission);
  }
  return made;
}

}  // namespace

TEST_CASE("BestPaths: the k best equal exhaustive search", "[core][inference]") {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Case c = RandomCase(seed);
    const auto all = AllPaths(c.lattice, c.graph, c.floor);
    for (const int count : {1, 3, 50}) {
      const auto found = core::BestPaths(c.lattice, c.graph, c.floor, count);
      CAPTURE(seed, count);
      REQUIRE(found.size() == std::min<std::size_t>(all.size(), count));
      for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(found[i].log_probability == Approx(all[i].log_probability).margin(1e-9));
        // Equal scores may be in either order: the path itself must have its score.
        const auto same = std::find_if(all.begin(), all.end(), [&](const core::NodePath& path) {
          return path.nodes == found[i].nodes;
        });
        REQUIRE(same != all.end());
        CHECK(found[i].log_probability == Approx(same->log_probability).margin(1e-9));
        for (std::size_t k = 0; k < i; ++k) CHECK(found[k].nodes != found[i].nodes);
      }
    }
  }
}

TEST_CASE("MaxMarginals: the best path through each candidate", "[core][inference]") {
  for (unsigned seed = 0; seed < 150; ++seed) {
    const Case c = RandomCase(seed);
    const auto all = AllPaths(c.lattice, c.graph, c.floor);
    const auto marginals = core::MaxMarginals(c.lattice, c.graph, c.floor);
    for (std::size_t t = 0; t < c.lattice.size(); ++t) {
      for (std::size_t j = 0; j < c.lattice[t].nodes.size(); ++j) {
        const auto through = std::find_if(all.begin(), all.end(), [&](const core::NodePath& path) {
          return path.nodes[t] == c.lattice[t].nodes[j];
        });
        const double got = marginals[t][static_cast<Eigen::Index>(j)];
        CAPTURE(seed, t, j);
        if (through == all.end()) {
          CHECK(got == -std::numeric_limits<double>::infinity());
        } else {
          CHECK(got == Approx(through->log_probability).margin(1e-9));
        }
      }
    }
  }
}

TEST_CASE("LastNodeDistribution: the strict node counts, however probable forbidden nodes are",
          "[core][inference]") {
  const std::vector<std::vector<std::int32_t>> sequences{{0, 0, 0}, {1, 1, 1}};
  const auto graph = core::CountTransitions(sequences, 2);
  core::Lattice lattice(3, {{0, 1}, Eigen::Vector2d(0, -5000)});
  lattice[1].log_emission = Eigen::Vector2d(-5000, 0);
  const auto last = core::LastNodeDistribution(lattice, graph, 0);
  CHECK(last[0] == Approx(1));
  CHECK(last[1] == Approx(0).margin(1e-12));

  // The first frame is most probable in a node without transitions.
  const auto dead_end =
      core::CountTransitions(std::vector<std::vector<std::int32_t>>{{0}, {1, 1}}, 2);
  CHECK(core::LastNodeDistribution(core::Lattice(3, {{0, 1}, Eigen::Vector2d(0, -2000)}), dead_end,
                                   0)[1] == Approx(1));
}

TEST_CASE("LastNodeDistribution: equals the sum over all paths", "[core][inference]") {
  for (unsigned seed = 0; seed < 150; ++seed) {
    const Case c = RandomCase(seed);
    const auto last = core::LastNodeDistribution(c.lattice, c.graph, c.floor);
    std::vector<double> sums(c.lattice.back().nodes.size(), 0);
    double total = 0;
    for (const core::NodePath& path : AllPaths(c.lattice, c.graph, c.floor)) {
      const auto& nodes = c.lattice.back().nodes;
      const auto at = std::find(nodes.begin(), nodes.end(), path.nodes.back()) - nodes.begin();
      sums[at] += std::exp(path.log_probability);
      total += std::exp(path.log_probability);
    }
    CAPTURE(seed);
    REQUIRE(last.size() == static_cast<Eigen::Index>(sums.size()));
    for (std::size_t j = 0; j < sums.size(); ++j) {
      CHECK(last[static_cast<Eigen::Index>(j)] ==
            Approx(total > 0 ? sums[j] / total : 0).margin(1e-9));
    }
  }
}

}  // namespace motiondb::tests::lattice_test
