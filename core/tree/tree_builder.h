// Builds the binary tree from scaled states (section III-B). Safe to call from any thread; uses
// only the threads lent to it.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// Called after each layer with its number. Returns false to stop the build.
using LayerDone = std::function<bool(int layer)>;

// Splits every node along its principal axis at the minimum-error threshold until no node of a
// layer splits. A node is a leaf if the unconstrained threshold leaves either side with fewer than
// `min_frames`; a node of a large part of all frames only if that is so without a few far ones too,
// which then lie where the planes put them (core/tree/divide_node.h). `states` is frames x
// dimensions, finite. The same states give the same tree, bit for bit, on any number of threads.
// INVALID_ARGUMENT for no frames or min_frames < 2; CANCELLED. Takes the memory of one copy of the
// states, and some readings of them a layer: axes are exact to single precision in nodes of up to
// 16,384 frames, and to a stated bound in larger ones (core/tree/principal_axis.h).
absl::StatusOr<Tree> BuildTree(const Eigen::Ref<const FrameMatrix>& states, int min_frames,
                               const ParallelFor& parallel, const LayerDone& layer_done = {});

// The same without the copy: rows of `states` are moved while the tree is built, and are at their
// places again afterwards, except where the build was cancelled.
absl::StatusOr<Tree> BuildTreeInPlace(Eigen::Map<FrameMatrix> states, int min_frames,
                                      const ParallelFor& parallel,
                                      const LayerDone& layer_done = {});

// A tree with more frames in it, and how far it is then from the tree that a build would give.
// Pure functions; safe to call from any thread.

// The tree with `added` (scaled states, frames x dimensions) as its last frames: each goes down to
// the leaf on its side of every threshold. Branches keep their numbers, layers and thresholds.
// FAILED_PRECONDITION if the tree does not know its thresholds. O(frames + added * depth *
// dimensions).
absl::StatusOr<Tree> GrowTree(const Tree& tree, const Eigen::Ref<const FrameMatrix>& added);

// The share, in [0, 1], of all frames that lie in leaves which the rule that built the tree
// (core/tree/divide_node.h, with `min_frames`) would divide by now, for the frames from
// `first_added` on came to lie in them. `states` (frames x dimensions, scaled) are those of all
// frames. Only leaves with added frames are looked at.
double DriftFraction(const Tree& tree, int first_added, const Eigen::Ref<const FrameMatrix>& states,
                     int min_frames, const ParallelFor& parallel);

}  // namespace motiondb::core
