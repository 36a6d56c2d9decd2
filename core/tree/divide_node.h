// The rule that a node is divided by (section III-B), and what it does about a few frames that are
// far from all others, as a glitch of a recording leaves them: such frames are all that the
// principal axis of many frames looks at, and the threshold then cuts off nothing else. By the
// paper's rule alone, two frames of one clip can so keep a whole database in one node.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/permuted_states.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// From here on a node is divided by all threads together; smaller ones side by side.
inline constexpr int kSharedFrames = 32768;

struct DivisionRule {
  int min_frames = 0;           // fewest frames of a node
  std::int32_t all_frames = 0;  // of the tree
};

// Places of a node's frames in PermutedStates.
struct NodePlaces {
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

// Divides a node as PermutedStates::Divide does; returns how many frames are on the left, or 0. A
// node that stays whole though it has at least 32 * min_frames frames and more than a quarter of
// the tree's is tried again without the frames that the threshold would have cut off, at most 32
// times and without at most a 32nd of its frames. If that divides it, `places` comes to be those of
// the frames that were divided: the others are beside them, and belong where the plane puts them.
// Else a leaf, as by the paper. The same on any number of threads; costs nothing where a node
// divides at once.
int DivideNode(const DivisionRule& rule, PermutedStates& permuted, NodePlaces& places,
               std::vector<float>& scratch, const ParallelFor& parallel, SplitPlane& plane);

// Whether a tree is a single node of at least 32 * min_frames frames: it tells no motion from
// another.
bool IsUndivided(const Tree& tree, int min_frames);

// Minimum-error thresholding (section III-B, eq. 5, after Kittler and Illingworth) of the
// projections onto the principal axis.

// Where to cut sorted values: the i in [2, n - 2] that minimises
//   J(i) = i log(var1 / i) + (n - i) log(var2 / (n - i)),
// var1 and var2 being the population variances of the first i and the last n - i values; the
// smallest such i of equals. (The paper prints argmax, which splits off single frames. A side needs
// two values to have a variance.) 0 where there is no cut: n < 4 or all values equal. `sorted` is
// ascending. O(n).
int MinimumErrorThreshold(std::span<const double> sorted);

// The frames that nodes were divided without (core/tree/divide_node.h), on their way down the tree
// while it is being built.
class FramesAside {
 public:
  // Those of a branch: what stands at its places, but for those that were divided. There they stay.
  void Add(std::int32_t branch, const NodePlaces& places, const NodePlaces& divided);
  // Sends those of a branch that has been divided to the sides of its plane where they lie.
  void PassDown(std::int32_t branch, const Branch& divided, const SplitPlane& plane,
                const PermutedStates& permuted);
  // Puts all that came to a leaf behind its frames, and makes the branches' ranges those of an
  // order of all frames.
  void PutBack(std::vector<Branch>& branches, std::vector<std::int32_t>& order) const;

 private:
  std::map<std::int32_t, std::vector<std::int32_t>> of_branch_;  // their places
};

}  // namespace motiondb::core
