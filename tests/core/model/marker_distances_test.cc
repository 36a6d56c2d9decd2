#include "core/model/marker_distances.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "tests/support/synthetic_states.h"

namespace motiondb::tests::marker_distances_test {
namespace {

double CostOf(const std::vector<core::TreeLink>& links, const Eigen::MatrixXd& costs) {
  double sum = 0;
  for (const auto& [node, parent] : links) sum += parent < 0 ? 0 : costs(node, parent);
  return sum;
}

// Cost of the cheapest of all spanning trees, by their Pruefer sequences.
double CheapestTree(const Eigen::MatrixXd& costs) {
  const auto nodes = static_cast<int>(costs.rows());
  if (nodes == 2) return costs(0, 1);
  std::vector<int> code(static_cast<std::size_t>(nodes - 2), 0);
  double best = std::numeric_limits<double>::infinity();
  while (true) {
    std::vector<int> degree(static_cast<std::size_t>(nodes), 1);
    for (const int node : code) ++degree[node];
    double sum = 0;
    for (const int node : code) {
      const int leaf = static_cast<int>(std::ranges::find(degree, 1) - degree.begin());
      sum += costs(leaf, node);
      --degree[leaf];
      --degree[node];
    }
    const auto a = std::ranges::find(degree, 1);
    const auto b = std::find(a + 1, degree.end(), 1);
    sum += costs(a - degree.begin(), b - degree.begin());
    best = std::min(best, sum);
    std::size_t digit = 0;
    while (digit < code.size() && ++code[digit] == nodes) code[digit++] = 0;
    if (digit == code.size()) return best;
  }
}

TEST_CASE("SpanningTree: no tree of all is cheaper", "[core][model]") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> cost(0, 1);
  for (int nodes = 2; nodes <= 6; ++nodes) {
    for (int trial = 0; trial < 10; ++trial) {
      Eigen::MatrixXd costs = Eigen::MatrixXd::Zero(nodes, nodes);
      for (int a = 0; a < nodes; ++a) {
        for (int b = 0; b < a; ++b) costs(a, b) = costs(b, a) = cost(random);
      }
      const auto links = core::SpanningTree(costs, trial % nodes);
      REQUIRE(static_cast<int>(links.size()) == nodes);
      CHECK(links.front().node == trial % nodes);
      CHECK(links.front().parent == -1);
      std::set<int> joined;
      for (const auto& [node, parent] : links) {
        CHECK((joined.empty() || joined.contains(parent)));
        CHECK(joined.insert(node).second);
      }
      CHECK(CostOf(links, costs) == Approx(CheapestTree(costs)));
    }
  }
  CHECK(core::SpanningTree(Eigen::MatrixXd(0, 0), 0).empty());
}

TEST_CASE("DistanceSpread: mean and variance within motions", "[core][model]") {
  const core::FrameMatrix a = WanderingStates(50, 18, 1);
  const core::FrameMatrix b = WanderingStates(80, 18, 2);
  core::DistanceSpread spread(3);
  spread.Add(a);
  spread.Add(b);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const auto distances = [&](const core::FrameMatrix& states) -> Eigen::ArrayXd {
        return (states.middleCols<3>(6 * i) - states.middleCols<3>(6 * j))
            .rowwise()
            .norm()
            .cast<double>();
      };
      const Eigen::ArrayXd in_a = distances(a);
      const Eigen::ArrayXd in_b = distances(b);
      CHECK(spread.Means()(i, j) == Approx((in_a.sum() + in_b.sum()) / 130).margin(1e-5));
      const double squares =
          (in_a - in_a.mean()).square().sum() + (in_b - in_b.mean()).square().sum();
      CHECK(spread.Variances()(i, j) == Approx(squares / 130).margin(1e-4));
    }
  }
}

}  // namespace
}  // namespace motiondb::tests::marker_distances_test
