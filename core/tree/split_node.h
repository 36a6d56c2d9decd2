// The split rule of a node (section III-B), and its handling of outliers. A few frames far from all
// others, such as a recording glitch, dominate the principal axis of many frames, and the threshold
// then cuts off only them. By the paper's rule alone, two frames of one clip can keep a whole
// database in one node.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/permuted_states.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// Nodes of this size or more are split by all threads together; smaller nodes in parallel.
inline constexpr int kSharedFrames = 32768;

struct SplitRule {
  int min_frames = 0;           // minimum frames of a node
  std::int32_t all_frames = 0;  // frames of the tree
};

// Range of a node's frames in PermutedStates: [begin, end).
struct NodeRange {
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

// Splits a node with PermutedStates::Split. Returns the number of frames on the left, or 0 for a
// leaf. If a node with at least 32 * min_frames frames and more than a quarter of the tree's does
// not split, removes the frames that the threshold would cut off and tries again: at most 32 times
// and at most 1/32 of its frames. On success `places` is the range of the frames that were split;
// the removed frames are beside it and belong to the side where the plane puts them. Deterministic
// for any number of threads; no extra cost if the first attempt succeeds.
int SplitNode(const SplitRule& rule, PermutedStates& permuted, NodeRange& places,
              std::vector<float>& scratch, const ParallelFor& parallel, SplitPlane& plane);

// Whether a tree is a single node of at least 32 * min_frames frames, so that it distinguishes no
// motions.
bool IsSingleNode(const Tree& tree, int min_frames);

// Minimum-error thresholding (section III-B, eq. 5, after Kittler and Illingworth) of projections
// onto the principal axis.

// Returns the i in [2, n - 2] that minimises
//   J(i) = i log(var1 / i) + (n - i) log(var2 / (n - i)),
// var1 and var2: population variances of the first i and the last n - i values. Ties: the smallest
// i. (The paper prints argmax, which splits off single frames. A side needs two values to have a
// variance.) 0 if n < 4 or all values are equal. `sorted` is ascending. O(n).
int MinimumErrorThreshold(std::span<const double> sorted);

// Outlier frames excluded from splits (see SplitNode), on their way down the tree during a build.
class OutlierFrames {
 public:
  // Adds the frames of a branch in `places` outside `kept`.
  void Add(std::int32_t branch, const NodeRange& places, const NodeRange& kept);
  // Moves the outliers of a split branch to its children, by its plane.
  void MoveToChildren(std::int32_t branch, const Branch& split, const SplitPlane& plane,
                      const PermutedStates& permuted);
  // Appends each leaf's outliers to its frames, and updates the branches' ranges to the order of
  // all frames.
  void AppendToLeaves(std::vector<Branch>& branches, std::vector<std::int32_t>& order) const;

 private:
  std::map<std::int32_t, std::vector<std::int32_t>> of_branch_;  // their places
};

}  // namespace motiondb::core
