// Builds the binary tree from scaled states (section III-B). Safe to call from any thread; uses
// only the threads lent to it.
#pragma once

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
// 16,384 frames, and to a stated bound in larger ones (core/tree/node_axis.h).
absl::StatusOr<Tree> BuildTree(const Eigen::Ref<const FrameMatrix>& states, int min_frames,
                               const ParallelFor& parallel, const LayerDone& layer_done = {});

}  // namespace motiondb::core
