// Builds and extends the binary tree (section III-B). Uses only the caller's threads.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// Called after each layer with its number. Returns false to stop the build.
using LayerDone = std::function<bool(int layer)>;

// Splits every node along its principal axis at the minimum-error threshold, until no node of a
// layer splits. A node is a leaf if the unconstrained threshold leaves fewer than `min_frames`
// frames on either side; exception for large nodes with outliers: core/tree/split_node.h.
// `states`: frames x dimensions, scaled, finite. The result is bitwise identical for any number of
// threads. INVALID_ARGUMENT for no frames or min_frames < 2; CANCELLED. Needs memory for one copy
// of the states. Axes are exact to single precision in nodes of up to 16,384 frames, with a bounded
// error in larger ones (core/tree/principal_axis.h).
absl::StatusOr<Tree> BuildTree(const Eigen::Ref<const FrameMatrix>& states, int min_frames,
                               const ParallelFor& parallel, const LayerDone& layer_done = {});

// The same without a copy: moves rows of `states` during the build and restores their order at the
// end, unless the build is cancelled.
absl::StatusOr<Tree> BuildTreeInPlace(Eigen::Map<FrameMatrix> states, int min_frames,
                                      const ParallelFor& parallel,
                                      const LayerDone& layer_done = {});

// Returns the tree with `added` (frames x dimensions, scaled) as its last frames: each goes to the
// leaf on its side of every threshold. Branches keep their numbers, layers and thresholds.
// FAILED_PRECONDITION if the tree has no thresholds. O(frames + added * depth * dimensions).
absl::StatusOr<Tree> GrowTree(const Tree& tree, const Eigen::Ref<const FrameMatrix>& added);

// Returns the fraction of all frames, in [0, 1], in leaves that a build would now split
// (core/tree/split_node.h, with `min_frames`) because of the frames from `first_added` on. Checks
// only leaves with added frames. `states`: all frames x dimensions, scaled.
double DriftFraction(const Tree& tree, int first_added, const Eigen::Ref<const FrameMatrix>& states,
                     int min_frames, const ParallelFor& parallel);

}  // namespace motiondb::core
