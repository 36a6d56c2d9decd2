#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "core/tree/node_gaussians.h"
#include "core/tree/tree_builder.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::grow_tree_test {
namespace {

constexpr int kMinFrames = 8;

core::Tree Build(const core::FrameMatrix& states) {
  auto tree = core::BuildTree(states, kMinFrames, core::RunSerially);
  REQUIRE(tree.ok());
  return *std::move(tree);
}

core::FrameMatrix Both(const core::FrameMatrix& a, const core::FrameMatrix& b) {
  core::FrameMatrix both(a.rows() + b.rows(), a.cols());
  both << a, b;
  return both;
}

}  // namespace

TEST_CASE("Tree: frames of the build are in their own leaves", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(3000, 18, 5);
  const core::Tree tree = Build(states);
  REQUIRE(tree.layer_count() > 4);
  REQUIRE(tree.planes().thresholds.size() == (tree.branches().size() - 1) / 2);
  for (int f = 0; f < tree.frame_count(); ++f) {
    const int bottom = tree.branch(tree.layer_count(), tree.node_of_frame(tree.layer_count(), f));
    CHECK(tree.LeafOf(states.row(f).data()) == bottom);
  }
}

TEST_CASE("GrowTree: added frames follow the thresholds, the others keep their nodes",
          "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(1500, 18, 5);
  const core::FrameMatrix added = WanderingStates(200, 18, 6);
  const core::Tree tree = Build(states);
  const auto grown = core::GrowTree(tree, added);
  REQUIRE(grown.ok());
  REQUIRE(grown->frame_count() == 1700);
  REQUIRE(grown->layer_count() == tree.layer_count());
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    REQUIRE(grown->node_count(layer) == tree.node_count(layer));
    for (int f = 0; f < 1500; ++f) {
      CHECK(grown->node_of_frame(layer, f) == tree.node_of_frame(layer, f));
    }
    // Descends the tree manually, one layer at a time.
    for (int i = 0; i < added.rows() && layer < tree.layer_count(); ++i) {
      const int node = grown->node_of_frame(layer, 1500 + i);
      const core::Branch& branch = tree.branches()[tree.branch(layer, node)];
      if (branch.left < 0) continue;
      const auto plane =
          std::count_if(tree.branches().begin(), tree.branches().begin() + tree.branch(layer, node),
                        [](const core::Branch& b) { return b.left >= 0; });
      const double along =
          tree.planes().axes.row(plane).cast<double>().dot(added.row(i).cast<double>());
      const bool left = along <= tree.planes().thresholds[plane];
      CHECK(grown->branch(layer + 1, grown->node_of_frame(layer + 1, 1500 + i)) ==
            (left ? branch.left : branch.right));
    }
  }
  // Growing in two steps equals growing in one.
  const auto first = core::GrowTree(tree, added.topRows(90));
  REQUIRE(first.ok());
  const auto second = core::GrowTree(*first, added.bottomRows(110));
  REQUIRE(second.ok());
  CHECK(second->frame_order() == grown->frame_order());
}

TEST_CASE("GrowTree: a tree without thresholds is refused, one of a single node grows",
          "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(300, 18, 5);
  const core::Tree tree = Build(states);
  const auto plain = core::Tree::Create(tree.frame_order(), tree.branches());
  REQUIRE(plain.ok());
  CHECK(core::GrowTree(*plain, states).status().code() == absl::StatusCode::kFailedPrecondition);
  const core::Tree single = Build(states.topRows(5));
  REQUIRE(single.layer_count() == 1);
  const auto grown = core::GrowTree(single, states.bottomRows(7));
  REQUIRE(grown.ok());
  CHECK(grown->frame_count() == 12);
}

TEST_CASE("Tree: planes that do not match its branches are refused", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(300, 18, 5);
  const core::Tree tree = Build(states);
  const auto refused = [&](const std::function<void(core::SplitPlanes&)>& corrupt) {
    core::SplitPlanes planes = tree.planes();
    corrupt(planes);
    return absl::IsDataLoss(
        core::Tree::Create(tree.frame_order(), tree.branches(), planes).status());
  };
  CHECK_FALSE(refused([](core::SplitPlanes&) {}));
  CHECK(refused([](core::SplitPlanes& p) { p.thresholds.pop_back(); }));
  CHECK(refused([](core::SplitPlanes& p) { p.thresholds.clear(); }));
  CHECK(refused([](core::SplitPlanes& p) { p.thresholds[0] = NAN; }));
  CHECK(refused([](core::SplitPlanes& p) { p.axes(0, 0) = INFINITY; }));
}

TEST_CASE("DriftFraction: the frames of leaves that a build would split", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(1500, 18, 5);
  const core::Tree tree = Build(states);
  // Nothing is added: the rule that made the leaves does not split them.
  CHECK(core::DriftFraction(tree, 1500, states, kMinFrames, core::RunSerially) == 0);
  // Two distant clusters in a former leaf.
  core::FrameMatrix heaps(60, 18);
  for (int i = 0; i < 60; ++i) {
    heaps.row(i) = states.row(0);
    heaps(i, 17) += 1e-4F * static_cast<float>(i % 7) + (i < 30 ? 0 : 0.5F);
  }
  const auto grown = core::GrowTree(tree, heaps);
  REQUIRE(grown.ok());
  const core::FrameMatrix all = Both(states, heaps);
  double frames = 0;
  for (const core::Branch& branch : grown->branches()) {
    const auto order =
        std::span(grown->frame_order()).subspan(branch.begin, branch.end - branch.begin);
    if (branch.left >= 0 || std::ranges::max(order) < 1500) continue;
    // Builds a tree from the leaf's frames alone to see whether they split.
    const std::vector<int> members(order.begin(), order.end());
    if (Build(all(members, Eigen::all)).layer_count() > 1)
      frames += static_cast<double>(members.size());
  }
  CHECK(frames > 0);
  CHECK(core::DriftFraction(*grown, 1500, all, kMinFrames, core::RunSerially) == frames / 1560);
}

TEST_CASE("NodeGaussians: grown Gaussians approximate those fitted to all frames", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(1500, 18, 5);
  const core::FrameMatrix added = WanderingStates(120, 18, 6);
  const core::Tree tree = Build(states);
  const auto grown = core::GrowTree(tree, added);
  REQUIRE(grown.ok());
  const core::FrameMatrix all = Both(states, added);
  const auto before = core::NodeGaussians::Fit(tree, states, core::RunSerially);
  const auto fitted = core::NodeGaussians::Fit(*grown, all, core::RunSerially);
  const auto kept_up = before.Grown(*grown, 1500, all, core::RunSerially);
  for (int b = 0; b < fitted.branch_count(); ++b) {
    CHECK((fitted.means().row(b) - kept_up.means().row(b)).cwiseAbs().maxCoeff() < 1e-5);
    const Eigen::ArrayXf ratio =
        kept_up.variances().row(b).array() / fitted.variances().row(b).array();
    CHECK(ratio.maxCoeff() < 1.001F);
    CHECK(ratio.minCoeff() > 0.999F);
    CHECK(kept_up.LogDensity(b, all.row(7).data()) ==
          Approx(fitted.LogDensity(b, all.row(7).data())).epsilon(1e-3).margin(0.01));
  }
  CHECK(kept_up.means() != before.means());
}

}  // namespace motiondb::tests::grow_tree_test
