// The rule that a node is divided by (section III-B), and what it does about a few frames that are
// far from all others, as a glitch of a recording leaves them: such frames are all that the
// principal axis of many frames looks at, and the threshold then cuts off nothing else. By the
// paper's rule alone, two frames of one clip can so keep a whole database in one node.
#pragma once

#include <cstdint>
#include <vector>

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

}  // namespace motiondb::core
