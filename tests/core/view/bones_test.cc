#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "core/model/model.h"
#include "core/view/clip_picture.h"
#include "tests/core/planning/walking_figure.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::bones_test {
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

// Bones of the walker as pairs of names, in either order.
std::set<std::set<std::string>> NamedBones(const std::vector<core::BoneEnds>& bones) {
  const core::MarkerSet set = WalkerSet();
  std::set<std::set<std::string>> named;
  for (const auto& [from, to] : bones) named.insert({set.markers[from], set.markers[to]});
  return named;
}

TEST_CASE("MarkerBones: the legs of a walker", "[core][view]") {
  const core::Model model = WalkingFigure{}.Model();
  auto states = core::ComputeStates(WalkerSet(), WalkingFigure{}.Motion());
  REQUIRE(states.ok());
  for (const auto& bones : {core::MarkerBones(model), core::MarkerBones(WalkerSet(), *states)}) {
    CHECK(bones.size() == WalkerSet().markers.size() - 1);
    const auto named = NamedBones(bones);
    for (const std::string side : {"L", "R"}) {
      for (const auto& [from, to] :
           std::vector<std::pair<std::string, std::string>>{{"Hip", "Thigh"},
                                                            {"Thigh", "Knee"},
                                                            {"Knee", "Shin"},
                                                            {"Shin", "Ankle"},
                                                            {"Ankle", "Heel"}}) {
        INFO(side << from << "-" << to);
        CHECK(named.contains({side + from, side + to}));
      }
    }
    CHECK(named.contains({"LHip", "RHip"}));
    // From the left hip outward: each bone begins at a point that was reached before.
    std::set<int> reached = {WalkerSet().landmarks.left_hip};
    for (const auto& [from, to] : bones) {
      CHECK(reached.contains(from));
      CHECK(reached.insert(to).second);
    }
  }
}

core::Skeleton Chain() {
  const auto joint = [](const char* name, int parent) {
    return core::Joint{.name = name, .parent = parent, .offset_m = {0, 0, 0.1}};
  };
  auto skeleton =
      core::Skeleton::Create("chain", {joint("root", -1), joint("hip", 0), joint("roll", 1),
                                       joint("knee", 2), joint("spine", 0), joint("hand", 4)});
  REQUIRE(skeleton.ok());
  return *std::move(skeleton);
}

TEST_CASE("MarkerBonesOf: markers that are joints have the skeleton's tree", "[core][view]") {
  const core::Skeleton skeleton = Chain();
  using Bones = std::vector<core::BoneEnds>;
  CHECK(core::JointBones(skeleton) == Bones{{0, 1}, {1, 2}, {2, 3}, {0, 4}, {4, 5}});
  core::MarkerSet all;
  all.markers = {"root", "hip", "roll", "knee", "spine", "hand"};
  CHECK(core::MarkerBonesOf(all, skeleton) == core::JointBones(skeleton));
  core::MarkerSet some;
  some.markers = {"hand", "knee", "hip", "root"};
  CHECK(core::MarkerBonesOf(some, skeleton) == Bones{{3, 2}, {2, 1}, {3, 0}});
  some.markers.push_back("LKNE");
  CHECK(core::MarkerBonesOf(some, skeleton).empty());
}

}  // namespace
}  // namespace motiondb::tests::bones_test
