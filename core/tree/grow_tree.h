// A tree with more frames in it, and how far it is then from the tree that a build would give.
// Pure functions; safe to call from any thread.
#pragma once

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// The tree with `added` (scaled states, frames x dimensions) as its last frames: each goes down to
// the leaf on its side of every threshold. Branches keep their numbers, layers and thresholds.
// FAILED_PRECONDITION if the tree does not know its thresholds. O(frames + added * depth *
// dimensions).
absl::StatusOr<Tree> GrowTree(const Tree& tree, const Eigen::Ref<const FrameMatrix>& added);

// The share, in [0, 1], of all frames that lie in leaves which the rule that built the tree
// (core/tree/divide_node.h, with `min_frames`) would divide by now, for the frames from
// `first_added` on came to lie in them. `states` (frames x dimensions, scaled) are those of all
// frames. Only leaves with added frames are looked at.
double StaleShare(const Tree& tree, int first_added, const Eigen::Ref<const FrameMatrix>& states,
                  int min_frames, const ParallelFor& parallel);

}  // namespace motiondb::core
