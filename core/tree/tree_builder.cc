#include "core/tree/tree_builder.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "core/tree/permuted_states.h"
#include "core/tree/split_node.h"

namespace motiondb::core {

namespace {

// Number of batches of small nodes; each reuses its own scratch memory.
constexpr int kBatches = 16;

// A node of at most this many frames is split down to its leaves while its rows are cached.
constexpr int kCachedFrames = 512;

// How a node is split, and its children if they are known.
struct NodeSplit {
  NodeRange kept;  // without outlier frames
  int left = 0;    // frames; 0: it is a leaf
  SplitPlane plane;
  std::unique_ptr<NodeSplit> children[2];
};

std::unique_ptr<NodeSplit> Split(const SplitRule& rule, PermutedStates& permuted,
                                 const NodeRange& places, std::vector<float>& scratch,
                                 const ParallelFor& parallel) {
  auto division = std::make_unique<NodeSplit>();
  division->kept = places;
  const std::int32_t frames = places.end - places.begin;
  if (frames < 2 * rule.min_frames) return division;
  division->left = SplitNode(rule, permuted, division->kept, scratch, parallel, division->plane);
  if (division->left == 0 || frames > kCachedFrames) return division;
  const auto [begin, end] = division->kept;
  const std::int32_t middle = begin + division->left;
  division->children[0] = Split(rule, permuted, {begin, middle}, scratch, parallel);
  division->children[1] = Split(rule, permuted, {middle, end}, scratch, parallel);
  return division;
}

SplitPlanes ToSplitPlanes(const std::vector<SplitPlane>& each, Eigen::Index dimensions) {
  SplitPlanes planes{FrameMatrix(std::ssize(each), dimensions), {}};
  for (const SplitPlane& plane : each) {
    planes.axes.row(std::ssize(planes.thresholds)) = plane.axis;
    planes.thresholds.push_back(plane.threshold);
  }
  return planes;
}

}  // namespace

absl::StatusOr<Tree> BuildTree(const Eigen::Ref<const FrameMatrix>& states, int min_frames,
                               const ParallelFor& parallel, const LayerDone& layer_done) {
  constexpr int kRowsAtOnce = 4096;
  FrameMatrix copy(states.rows(), states.cols());
  const auto rows = static_cast<int>(states.rows());
  parallel((rows + kRowsAtOnce - 1) / kRowsAtOnce, [&](int block) {
    const int first = block * kRowsAtOnce;
    const int count = std::min(kRowsAtOnce, rows - first);
    copy.middleRows(first, count) = states.middleRows(first, count);
  });
  return BuildTreeInPlace({copy.data(), copy.rows(), copy.cols()}, min_frames, parallel,
                          layer_done);
}

absl::StatusOr<Tree> BuildTreeInPlace(Eigen::Map<FrameMatrix> states, int min_frames,
                                      const ParallelFor& parallel, const LayerDone& layer_done) {
  if (states.rows() == 0) return InvalidArgument("states: expected at least one frame");
  if (min_frames < 2) return InvalidArgument("min_frames: expected at least 2, got {}", min_frames);

  PermutedStates permuted(states);
  OutlierFrames aside;
  const SplitRule rule{min_frames, static_cast<std::int32_t>(states.rows())};
  std::vector<Branch> branches{{.begin = 0, .end = static_cast<std::int32_t>(states.rows())}};
  std::vector<SplitPlane> planes;
  std::vector<std::vector<float>> scratch(kBatches);

  // A branch of the lowest layer that may split.
  struct Open {
    std::int32_t branch = 0;
    std::unique_ptr<NodeSplit> division;  // if it is known
  };
  std::vector<Open> open;
  open.push_back({0, nullptr});
  for (int layer = 1; !open.empty(); ++layer) {
    const auto frames = [&](const Open& o) {
      return branches[o.branch].end - branches[o.branch].begin;
    };
    std::erase_if(open, [&](const Open& o) { return frames(o) < 2 * min_frames; });

    // The largest nodes first: those shared by all threads, then the others, for balanced load.
    std::vector<std::size_t> work;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (open[i].division == nullptr) work.push_back(i);
    }
    std::stable_sort(work.begin(), work.end(), [&](std::size_t a, std::size_t b) {
      return frames(open[a]) > frames(open[b]);
    });
    const auto split = [&](std::size_t i, int batch, const ParallelFor& threads) {
      const Branch& branch = branches[open[i].branch];
      open[i].division = Split(rule, permuted, {branch.begin, branch.end}, scratch[batch], threads);
    };
    std::size_t shared = 0;
    while (shared < work.size() && frames(open[work[shared]]) >= kSharedFrames) {
      split(work[shared++], 0, parallel);
    }
    parallel(kBatches, [&](int batch) {
      for (std::size_t i = shared + batch; i < work.size(); i += kBatches)
        split(work[i], batch, RunSerially);
    });

    std::vector<Open> children;
    for (Open& node : open) {
      NodeSplit& division = *node.division;
      if (division.left == 0) continue;
      const std::int32_t b = node.branch;
      const auto left = static_cast<std::int32_t>(branches.size());
      branches[b].left = left;
      branches[b].right = left + 1;
      const auto [begin, end] = division.kept;
      aside.Add(b, {branches[b].begin, branches[b].end}, division.kept);
      aside.MoveToChildren(b, branches[b], division.plane, permuted);
      planes.push_back(std::move(division.plane));
      const std::int32_t middle = begin + division.left;
      const std::int32_t below = branches[b].layer + 1;
      branches.push_back({.parent = b, .begin = begin, .end = middle, .layer = below});
      branches.push_back({.parent = b, .begin = middle, .end = end, .layer = below});
      children.push_back({left, std::move(division.children[0])});
      children.push_back({left + 1, std::move(division.children[1])});
    }
    open = std::move(children);
    if (layer_done && !layer_done(layer)) return absl::CancelledError("the build was cancelled");
  }

  permuted.Restore(parallel);
  std::vector<std::int32_t> order = std::move(permuted.order());
  aside.AppendToLeaves(branches, order);
  for (const Branch& branch : branches) {
    if (branch.left < 0) std::sort(order.begin() + branch.begin, order.begin() + branch.end);
  }
  return Tree::Create(std::move(order), std::move(branches), ToSplitPlanes(planes, states.cols()));
}

absl::StatusOr<Tree> GrowTree(const Tree& tree, const Eigen::Ref<const FrameMatrix>& added) {
  if (!tree.has_planes()) {
    return FailedPrecondition("the tree has no split thresholds; rebuild the model");
  }
  std::vector<std::vector<std::int32_t>> of_leaf(tree.branches().size());
  for (Eigen::Index i = 0; i < added.rows(); ++i) {
    of_leaf[tree.LeafOf(added.row(i).data())].push_back(tree.frame_count() +
                                                        static_cast<std::int32_t>(i));
  }
  // Ranges begin and end at leaf boundaries. shift: number of frames added before each place.
  std::vector<std::int32_t> shift(static_cast<std::size_t>(tree.frame_count()) + 1);
  for (std::size_t b = 0; b < of_leaf.size(); ++b) {
    shift[tree.branches()[b].end] += static_cast<std::int32_t>(of_leaf[b].size());
  }
  std::partial_sum(shift.begin(), shift.end(), shift.begin());

  std::vector<Branch> branches = tree.branches();
  std::vector<std::int32_t> order(tree.frame_order().size() + added.rows());
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& before = tree.branches()[b];
    branches[b].begin += shift[before.begin];
    branches[b].end += shift[before.end];
    if (before.left >= 0) continue;
    const auto rest =
        std::copy(tree.frame_order().begin() + before.begin,
                  tree.frame_order().begin() + before.end, order.begin() + branches[b].begin);
    std::copy(of_leaf[b].begin(), of_leaf[b].end(), rest);
  }
  return Tree::Create(std::move(order), std::move(branches), tree.planes());
}

double DriftFraction(const Tree& tree, int first_added, const Eigen::Ref<const FrameMatrix>& states,
                     int min_frames, const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  const SplitRule rule{min_frames, tree.frame_count()};
  std::vector<std::int32_t> stale(branches.size());
  const auto is_shared = [&](int b) {
    return branches[b].end - branches[b].begin >= kSharedFrames;
  };
  const auto check_leaf = [&](int b, const ParallelFor& threads) {
    const Branch& leaf = branches[b];
    const int count = leaf.end - leaf.begin;
    // The frames of a leaf are ascending.
    if (leaf.left >= 0 || tree.frame_order()[leaf.end - 1] < first_added || count < 2 * min_frames)
      return;
    FrameMatrix rows(count, states.cols());
    for (int i = 0; i < count; ++i) rows.row(i) = states.row(tree.frame_order()[leaf.begin + i]);
    std::vector<float> scratch;
    SplitPlane plane;
    PermutedStates permuted({rows.data(), rows.rows(), rows.cols()});
    NodeRange places{0, count};
    if (SplitNode(rule, permuted, places, scratch, threads, plane) > 0) stale[b] = count;
  };
  const auto branch_count = static_cast<int>(branches.size());
  parallel(branch_count, [&](int b) {
    if (!is_shared(b)) check_leaf(b, RunSerially);
  });
  for (int b = 0; b < branch_count; ++b) {
    if (is_shared(b)) check_leaf(b, parallel);
  }
  return std::accumulate(stale.begin(), stale.end(), 0.0) / tree.frame_count();
}

}  // namespace motiondb::core
