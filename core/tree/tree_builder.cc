#include "core/tree/tree_builder.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "core/tree/divide_node.h"
#include "core/tree/frames_aside.h"
#include "core/tree/permuted_states.h"

namespace motiondb::core {
namespace {

// Lots that the smaller nodes are dealt out in, each with memory of its own that is used again.
constexpr int kLots = 16;

SplitPlanes Together(const std::vector<SplitPlane>& each, Eigen::Index dimensions) {
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
  if (states.rows() == 0) return InvalidArgument("a tree needs at least one frame");
  if (min_frames < 2) return InvalidArgument("min_frames: expected at least 2, got {}", min_frames);

  PermutedStates permuted(states, parallel);
  FramesAside aside;
  const DivisionRule rule{min_frames, static_cast<std::int32_t>(states.rows())};
  std::vector<Branch> branches{{.begin = 0, .end = static_cast<std::int32_t>(states.rows())}};
  std::vector<SplitPlane> planes;
  std::vector<std::vector<float>> scratch(kLots);

  std::vector<std::int32_t> open{0};  // branches of the lowest layer that may yet split
  for (int layer = 1; !open.empty(); ++layer) {
    const auto frames = [&](std::int32_t b) { return branches[b].end - branches[b].begin; };
    std::erase_if(open, [&](std::int32_t b) { return frames(b) < 2 * min_frames; });

    // The largest first: the shared ones, then the others, so that threads end at about one time.
    std::vector<std::int32_t> work(open.size());
    for (std::size_t i = 0; i < open.size(); ++i) work[i] = static_cast<std::int32_t>(i);
    std::stable_sort(work.begin(), work.end(), [&](std::int32_t a, std::int32_t b) {
      return frames(open[a]) > frames(open[b]);
    });
    std::vector<int> left_counts(open.size());
    std::vector<SplitPlane> open_planes(open.size());
    std::vector<NodePlaces> divided(open.size());
    const auto divide = [&](std::int32_t i, int lot, const ParallelFor& threads) {
      divided[i] = {branches[open[i]].begin, branches[open[i]].end};
      left_counts[i] =
          DivideNode(rule, permuted, divided[i], scratch[lot], threads, open_planes[i]);
    };
    std::size_t shared = 0;
    while (shared < work.size() && frames(open[work[shared]]) >= kSharedFrames) {
      divide(work[shared++], 0, parallel);
    }
    parallel(kLots, [&](int lot) {
      for (std::size_t i = shared + lot; i < work.size(); i += kLots)
        divide(work[i], lot, Serially);
    });

    std::vector<std::int32_t> children;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (left_counts[i] == 0) continue;
      const std::int32_t b = open[i];
      const auto left = static_cast<std::int32_t>(branches.size());
      branches[b].left = left;
      branches[b].right = left + 1;
      const auto [begin, end] = divided[i];
      aside.Add(b, {branches[b].begin, branches[b].end}, divided[i], permuted.order());
      aside.PassDown(b, branches[b], open_planes[i], states);
      planes.push_back(std::move(open_planes[i]));
      const std::int32_t middle = begin + left_counts[i];
      const std::int32_t below = branches[b].layer + 1;
      branches.push_back({.parent = b, .begin = begin, .end = middle, .layer = below});
      branches.push_back({.parent = b, .begin = middle, .end = end, .layer = below});
      children.push_back(left);
      children.push_back(left + 1);
    }
    open = std::move(children);
    if (layer_done && !layer_done(layer)) return absl::CancelledError("the build was cancelled");
  }

  std::vector<std::int32_t> order = std::move(permuted.order());
  aside.PutBack(branches, order);
  for (const Branch& branch : branches) {
    if (branch.left < 0) std::sort(order.begin() + branch.begin, order.begin() + branch.end);
  }
  return Tree::Create(std::move(order), std::move(branches), Together(planes, states.cols()));
}

}  // namespace motiondb::core
