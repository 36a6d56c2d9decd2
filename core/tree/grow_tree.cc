#include "core/tree/grow_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "core/tree/divide_node.h"

namespace motiondb::core {

absl::StatusOr<Tree> GrowTree(const Tree& tree, const Eigen::Ref<const FrameMatrix>& added) {
  if (!tree.has_planes()) {
    return FailedPrecondition("the tree does not know where it was divided");
  }
  std::vector<std::vector<std::int32_t>> of_leaf(tree.branches().size());
  for (Eigen::Index i = 0; i < added.rows(); ++i) {
    of_leaf[tree.LeafOf(added.row(i).data())].push_back(tree.frame_count() +
                                                        static_cast<std::int32_t>(i));
  }
  // Ranges begin and end where leaves do: how many frames are added before each place.
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

double StaleShare(const Tree& tree, int first_added, const Eigen::Ref<const FrameMatrix>& states,
                  int min_frames, const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  const DivisionRule rule{min_frames, tree.frame_count()};
  std::vector<std::int32_t> stale(branches.size());
  const auto is_shared = [&](int b) {
    return branches[b].end - branches[b].begin >= kSharedFrames;
  };
  const auto look = [&](int b, const ParallelFor& threads) {
    const Branch& leaf = branches[b];
    const int count = leaf.end - leaf.begin;
    // A leaf's frames ascend.
    if (leaf.left >= 0 || tree.frame_order()[leaf.end - 1] < first_added || count < 2 * min_frames)
      return;
    FrameMatrix rows(count, states.cols());
    for (int i = 0; i < count; ++i) rows.row(i) = states.row(tree.frame_order()[leaf.begin + i]);
    std::vector<float> scratch;
    SplitPlane plane;
    PermutedStates permuted(rows, threads);
    NodePlaces places{0, count};
    if (DivideNode(rule, permuted, places, scratch, threads, plane) > 0) stale[b] = count;
  };
  const auto branch_count = static_cast<int>(branches.size());
  parallel(branch_count, [&](int b) {
    if (!is_shared(b)) look(b, Serially);
  });
  for (int b = 0; b < branch_count; ++b) {
    if (is_shared(b)) look(b, parallel);
  }
  return std::accumulate(stale.begin(), stale.end(), 0.0) / tree.frame_count();
}

}  // namespace motiondb::core
