#include "core/tree/split_node.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

#include "core/tree/tree_builder.h"
#include "tests/core/tree/exact_split.h"
#include "tests/core/tree/real_states.h"
#include "tests/core/tree/threads.h"
#include "tests/support/real_data.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::split_node_test {
namespace {

constexpr int kMinFrames = 16;
using Frames = std::vector<std::int32_t>;

core::Tree Build(const core::FrameMatrix& states,
                 const core::ParallelFor& parallel = core::RunSerially) {
  auto tree = core::BuildTree(states, kMinFrames, parallel);
  REQUIRE(tree.ok());
  return *std::move(tree);
}

// Moves pairs of consecutive frames far away, like glitches of two frames: each pair in its own
// dimension and 1.5 times as far as the previous pair.
core::FrameMatrix WithGlitches(core::FrameMatrix states, const Frames& first_frames) {
  float far = 500;
  Eigen::Index dimension = 0;
  for (const std::int32_t f : first_frames) {
    for (const std::int32_t g : {f, f + 1}) states(g, dimension) += far;
    far *= -1.5F;
    dimension = (dimension + 1) % states.cols();
  }
  return states;
}

core::FrameMatrix Without(const core::FrameMatrix& states, const Frames& first_frames) {
  std::vector<int> others;
  for (int f = 0; f < states.rows(); ++f) {
    const bool far = std::ranges::any_of(first_frames, [&](int g) { return f == g || f == g + 1; });
    if (!far) others.push_back(f);
  }
  return states(others, Eigen::all);
}

// Returns a branch's frames, ascending.
Frames FramesOf(const core::Tree& tree, const core::Branch& branch) {
  Frames frames(tree.frame_order().begin() + branch.begin, tree.frame_order().begin() + branch.end);
  std::ranges::sort(frames);
  return frames;
}

// Returns the frames of each branch by the paper's rule alone.
std::vector<Frames> NodesOfPaper(core::FrameMatrix states) {
  core::PermutedStates permuted({states.data(), states.rows(), states.cols()});
  std::vector<core::NodeRange> nodes{{0, static_cast<std::int32_t>(states.rows())}};
  std::vector<Frames> frames;
  std::vector<float> scratch;
  core::SplitPlane plane;
  for (std::size_t n = 0; n < nodes.size(); ++n) {  // children are appended: layer by layer
    const auto [begin, end] = nodes[n];
    const auto first = permuted.order().begin();
    std::ranges::sort(frames.emplace_back(first + begin, first + end));
    if (end - begin < 2 * kMinFrames) continue;
    const int left = permuted.Split(begin, end, kMinFrames, scratch, core::RunSerially, plane);
    if (left == 0) continue;
    nodes.push_back({begin, begin + left});
    nodes.push_back({begin + left, end});
  }
  return frames;
}

void CheckIsPapers(const core::FrameMatrix& states) {
  const core::Tree tree = Build(states);
  const std::vector<Frames> nodes = NodesOfPaper(states);
  REQUIRE(tree.branches().size() == nodes.size());
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    CHECK(FramesOf(tree, tree.branches()[b]) == nodes[b]);
  }
}

}  // namespace

TEST_CASE("SplitNode: a few outlier frames do not change the tree of the others", "[core][tree]") {
  const core::FrameMatrix clean = WanderingStates(3000, 18, 5);
  for (const Frames& glitches :
       {Frames{700}, Frames{0, 2998}, Frames{100, 600, 1400, 1402, 2000, 2500}}) {
    const core::FrameMatrix states = WithGlitches(clean, glitches);
    REQUIRE(NodesOfPaper(states).size() == 1);
    const core::Tree tree = Build(states);
    const core::FrameMatrix others = Without(states, glitches);
    const core::Tree alone = Build(others);
    REQUIRE(tree.branches().size() == alone.branches().size());
    REQUIRE(tree.frame_count() == 3000);
    int far = 0;
    for (int f = 0; f < 3000; ++f) {
      const int leaf = tree.branch(tree.layer_count(), tree.node_of_frame(tree.layer_count(), f));
      CHECK(tree.LeafOf(states.row(f).data()) == leaf);  // the outliers too
      if (states.row(f) != clean.row(f)) {
        ++far;
        continue;
      }
      CHECK(leaf ==
            alone.branch(alone.layer_count(), alone.node_of_frame(alone.layer_count(), f - far)));
    }
    for (const core::Branch& branch : tree.branches()) {
      CHECK(branch.end - branch.begin >= kMinFrames);
      if (branch.left < 0) {
        CHECK(std::is_sorted(tree.frame_order().begin() + branch.begin,
                             tree.frame_order().begin() + branch.end));
      }
    }
  }
}

TEST_CASE("SplitNode: outliers do not depend on threads", "[core][tree]") {
  for (const int frames : {9000, 70'000}) {
    const core::FrameMatrix states =
        WithGlitches(WanderingStates(frames, 12, 23), {50, 4000, 5000, 8997});
    REQUIRE(NodesOfPaper(states).size() == 1);
    const core::Tree serial = Build(states);
    const core::Tree other = Build(states, OnFourThreads);
    CHECK(serial.layer_count() > 5);
    CHECK(other.frame_order() == serial.frame_order());
    CHECK(other.branches().size() == serial.branches().size());
    CHECK(other.planes().thresholds == serial.planes().thresholds);
  }
}

TEST_CASE("SplitNode: small nodes, and nodes of few frames, follow the paper's rule",
          "[core][tree]") {
  // A leaf for two outliers in a small tree ...
  CheckIsPapers(WithGlitches(WanderingStates(20 * kMinFrames, 18, 5), {100}));
  CHECK(Build(WithGlitches(WanderingStates(20 * kMinFrames, 18, 5), {100})).layer_count() == 1);
  // ... and in a large one: six groups far apart, with two outliers in one of them that are nearer
  // than the groups.
  core::FrameMatrix states = WanderingStates(6000, 18, 5);
  for (int f = 0; f < 6000; ++f) states(f, f / 1000) += 1000;
  states(5500, 17) += 300;
  states(5501, 17) += 300;
  CheckIsPapers(states);
  const core::Tree tree = Build(states);
  CHECK(std::ranges::any_of(tree.branches(), [](const core::Branch& branch) {
    return branch.left < 0 && branch.end - branch.begin >= 32 * kMinFrames;
  }));
}

TEST_CASE("SplitNode: too many outliers leave a single node, which is reported", "[core][tree]") {
  const core::FrameMatrix clean = WanderingStates(600, 24, 5);
  CHECK_FALSE(core::IsSingleNode(Build(clean), kMinFrames));
  Frames glitches;
  for (int f = 0; f < 600; f += 30) glitches.push_back(f);
  const core::FrameMatrix states = WithGlitches(clean, glitches);
  const core::Tree tree = Build(states);
  REQUIRE(tree.layer_count() == 1);
  CHECK(tree.frame_order()[17] == 17);
  CHECK(core::IsSingleNode(tree, kMinFrames));
  CHECK_FALSE(core::IsSingleNode(Build(states.topRows(31 * kMinFrames)), kMinFrames));
  // Equal frames have no threshold.
  CHECK(core::IsSingleNode(Build(core::FrameMatrix::Zero(600, 18)), kMinFrames));
}

TEST_CASE("SplitNode: a tree of one node that a new build would split is stale", "[core][tree]") {
  const core::FrameMatrix states = WithGlitches(WanderingStates(1500, 18, 5), {700});
  Frames all(1500);
  std::iota(all.begin(), all.end(), 0);
  const auto single = core::Tree::Create(all, {{.begin = 0, .end = 1500}});
  REQUIRE(single.ok());
  CHECK(core::DriftFraction(*single, 1400, states, kMinFrames, core::RunSerially) == 1);
}

TEST_CASE("SplitNode: a glitch of one recorded clip does not affect the tree of all",
          "[core][tree][data][slow]") {
  MOTIONDB_REQUIRE_DATA();
  // 09_10 begins with its arms stretched out and jumps into its first step.
  const auto jogging = [](const ListedClip& clip) {  // the index has more columns
    return clip.label.find("\tjog\t") != std::string::npos;
  };
  const auto other_jogging = [&](const ListedClip& clip) {
    return jogging(clip) && clip.path.stem() != "09_10";
  };
  for (const double frame_rate_hz : {60.0, 120.0}) {
    CAPTURE(frame_rate_hz);
    // Robust scales reduce its jump: a frame further away is added.
    const core::FrameMatrix states =
        WithGlitches(LoadScaledStates("index.tsv", frame_rate_hz, jogging), {100});
    REQUIRE(NodesOfPaper(states).size() == 1);
    const core::Tree tree = Build(states);
    const core::Tree others = Build(LoadScaledStates("index.tsv", frame_rate_hz, other_jogging));
    CHECK(tree.layer_count() >= others.layer_count() - 2);
    CHECK(tree.branches().size() > others.branches().size() * 3 / 4);
    for (const core::Branch& branch : tree.branches()) {
      if (branch.left < 0) CHECK(branch.end - branch.begin < states.rows() / 4);
    }
  }
}

TEST_CASE("SplitNode: recorded motion without outliers has the paper's tree",
          "[core][tree][data][slow]") {
  MOTIONDB_REQUIRE_DATA();
  for (const double frame_rate_hz : {30.0, 60.0, 120.0}) {
    CAPTURE(frame_rate_hz);
    CheckIsPapers(LoadScaledStates("sets/database1.train.tsv", frame_rate_hz));
    CheckIsPapers(LoadScaledStates("sets/database2.tsv", frame_rate_hz));
  }
  CheckIsPapers(LoadScaledStates("index.tsv", 60, IsHdm05));
}

}  // namespace motiondb::tests::split_node_test
