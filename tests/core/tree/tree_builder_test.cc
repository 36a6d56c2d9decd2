#include "core/tree/tree_builder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/core/tree/exact_split.h"
#include "tests/core/tree/threads.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::tree_builder_test {
namespace {

core::Tree Build(const core::FrameMatrix& states, int min_frames,
                 const core::ParallelFor& parallel = core::RunSerially) {
  auto tree = core::BuildTree(states, min_frames, parallel);
  REQUIRE(tree.ok());
  return *std::move(tree);
}

}  // namespace

TEST_CASE("BuildTreeInPlace: the same tree, and every row is at its place again", "[core][tree]") {
  for (const int frames : {1, 40, 900}) {
    const core::FrameMatrix states = WanderingStates(frames, 70, 3);
    core::FrameMatrix moved = states;
    const auto tree = core::BuildTree(states, 4, core::RunSerially);
    const auto in_place =
        core::BuildTreeInPlace({moved.data(), moved.rows(), moved.cols()}, 4, core::RunSerially);
    REQUIRE(tree.ok());
    REQUIRE(in_place.ok());
    CHECK(moved == states);
    CHECK(in_place->frame_order() == tree->frame_order());
    CHECK(in_place->branches().size() == tree->branches().size());
  }
}

TEST_CASE("BuildTree: every frame is in exactly one node of each layer", "[core][tree]") {
  const core::Tree tree = Build(WanderingStates(900, 12, 3), 4);
  REQUIRE(tree.layer_count() > 3);
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    std::vector<int> owner(tree.frame_count(), -1);
    int frames = 0;
    for (int node = 0; node < tree.node_count(layer); ++node) {
      const core::Branch& branch = tree.branches()[tree.branch(layer, node)];
      for (int i = branch.begin; i < branch.end; ++i, ++frames) {
        CHECK(owner[tree.frame_order()[i]] == -1);
        owner[tree.frame_order()[i]] = node;
      }
    }
    CHECK(frames == tree.frame_count());
    for (int f = 0; f < tree.frame_count(); ++f) CHECK(tree.node_of_frame(layer, f) == owner[f]);
  }
}

TEST_CASE("BuildTree: layers are consistent", "[core][tree]") {
  const core::Tree tree = Build(WanderingStates(700, 12, 5), 4);
  CHECK(tree.node_count(1) == 1);
  CHECK(tree.parent(1, 0) == -1);
  int total = 0;
  for (int layer = 1; layer <= tree.layer_count(); ++layer) total += tree.node_count(layer);
  CHECK(tree.total_node_count() == total);
  for (int layer = 1; layer < tree.layer_count(); ++layer) {
    bool split = false;
    int next = 0;
    for (int node = 0; node < tree.node_count(layer); ++node) {
      const int children = tree.child_count(layer, node);
      CHECK(tree.first_child(layer, node) == next);
      REQUIRE((children == 1 || children == 2));
      split |= children == 2;
      for (int c = next; c < next + children; ++c) CHECK(tree.parent(layer + 1, c) == node);
      if (children == 1) CHECK(tree.branch(layer + 1, next) == tree.branch(layer, node));
      next += children;
    }
    CHECK(next == tree.node_count(layer + 1));
    CHECK(split);  // a layer without splits is the last
  }
}

TEST_CASE("BuildTree: no node has fewer frames than the minimum", "[core][tree]") {
  for (const int min_frames : {2, 5, 16, 100}) {
    const core::Tree tree = Build(WanderingStates(600, 6, 11), min_frames);
    for (const core::Branch& branch : tree.branches())
      CHECK(branch.end - branch.begin >= min_frames);
  }
}

TEST_CASE("BuildTree: the tree is deterministic and does not depend on threads", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(9000, 12, 17);  // the root is summed in runs
  const core::Tree serial = Build(states, 8);
  for (const core::Tree& other : {Build(states, 8), Build(states, 8, OnFourThreads)}) {
    CHECK(other.frame_order() == serial.frame_order());
    REQUIRE(other.branches().size() == serial.branches().size());
    for (std::size_t b = 0; b < serial.branches().size(); ++b) {
      CHECK(other.branches()[b].begin == serial.branches()[b].begin);
      CHECK(other.branches()[b].left == serial.branches()[b].left);
    }
  }
}

TEST_CASE("BuildTree: large nodes, whose frames all threads share, do not depend on them either",
          "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(70'000, 12, 23);
  const core::Tree serial = Build(states, 16);
  const core::Tree other = Build(states, 16, OnFourThreads);
  CHECK(other.frame_order() == serial.frame_order());
  CHECK(other.branches().size() == serial.branches().size());
}

TEST_CASE("BuildTree: nodes equal those of exact covariance, decomposition and sort",
          "[core][tree]") {
  for (const int frames : {200, 3000, 6000}) {
    core::FrameMatrix states = WanderingStates(frames, 24, static_cast<unsigned>(frames));
    states.row(7) = states.row(150);  // equal projections are ordered by frame number
    states.row(8) = states.row(150);
    const core::Tree tree = Build(states, 8);
    const auto exact = ExactNodes(states, 8);
    REQUIRE(tree.branches().size() == exact.size());
    for (std::size_t b = 0; b < exact.size(); ++b) {
      const core::Branch& branch = tree.branches()[b];
      std::vector<std::int32_t> got(tree.frame_order().begin() + branch.begin,
                                    tree.frame_order().begin() + branch.end);
      std::sort(got.begin(), got.end());
      CHECK(got == exact[b]);
    }
  }
}

TEST_CASE("BuildTree: frames of a leaf are in order", "[core][tree]") {
  const core::Tree tree = Build(WanderingStates(2000, 12, 29), 8);
  for (const core::Branch& branch : tree.branches()) {
    if (branch.left >= 0) continue;
    CHECK(std::is_sorted(tree.frame_order().begin() + branch.begin,
                         tree.frame_order().begin() + branch.end));
  }
}

TEST_CASE("BuildTree: many equal frames are split by their numbers", "[core][tree]") {
  core::FrameMatrix states = core::FrameMatrix::Zero(400, 6);
  for (int f = 0; f < 400; ++f) states(f, 0) = static_cast<float>(f % 5);
  const core::Tree tree = Build(states, 16);
  REQUIRE(tree.branches().size() > 1);
  const auto exact = ExactNodes(states, 16);
  REQUIRE(exact.size() == tree.branches().size());
  for (std::size_t b = 0; b < exact.size(); ++b) {
    const core::Branch& branch = tree.branches()[b];
    std::vector<std::int32_t> got(tree.frame_order().begin() + branch.begin,
                                  tree.frame_order().begin() + branch.end);
    std::sort(got.begin(), got.end());
    CHECK(got == exact[b]);
  }
}

TEST_CASE("BuildTree: equal frames make one node", "[core][tree]") {
  const core::Tree tree = Build(core::FrameMatrix::Constant(50, 6, 1.5f), 2);
  CHECK(tree.layer_count() == 1);
  CHECK(tree.total_node_count() == 1);
  CHECK(Build(core::FrameMatrix::Zero(1, 6), 16).layer_count() == 1);
}

TEST_CASE("BuildTree: refuses invalid input and can be cancelled", "[core][tree]") {
  const auto code = [](const auto& result) { return result.status().code(); };
  CHECK(code(core::BuildTree(core::FrameMatrix(0, 6), 16, core::RunSerially)) ==
        absl::StatusCode::kInvalidArgument);
  CHECK(code(core::BuildTree(core::FrameMatrix::Zero(9, 6), 1, core::RunSerially)) ==
        absl::StatusCode::kInvalidArgument);
  CHECK(code(core::BuildTree(WanderingStates(600, 6, 1), 4, core::RunSerially,
                             [](int) { return false; })) == absl::StatusCode::kCancelled);
}

TEST_CASE("Tree: refuses parts that are not a tree", "[core][tree]") {
  const core::Tree tree = Build(WanderingStates(300, 6, 1), 4);
  REQUIRE(tree.branches().size() > 3);
  const auto refused = [](std::vector<std::int32_t> order, std::vector<core::Branch> branches) {
    return core::Tree::Create(std::move(order), std::move(branches)).status().code() ==
           absl::StatusCode::kDataLoss;
  };
  CHECK(refused({}, tree.branches()));
  CHECK(refused(tree.frame_order(), {}));
  auto order = tree.frame_order();
  order[0] = order[1];
  CHECK(refused(order, tree.branches()));
  order[0] = -1;
  CHECK(refused(order, tree.branches()));
  for (std::size_t b = 0; b < tree.branches().size(); ++b) {
    for (auto field : {&core::Branch::begin, &core::Branch::end, &core::Branch::left,
                       &core::Branch::right, &core::Branch::layer}) {
      auto branches = tree.branches();
      branches[b].*field += 1;
      CAPTURE(b);
      CHECK(refused(tree.frame_order(), branches));
    }
  }
}

}  // namespace motiondb::tests::tree_builder_test
