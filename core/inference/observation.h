// Common steps of queries: scaling the observation and finding similar stored frames.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;

// Returns the observation's states (frames x dimensions), scaled as the model's. INVALID_ARGUMENT
// if it is empty, has another marker set or frame rate than the model, or an infinite number.
absl::StatusOr<FrameMatrix> ScaledObservation(const Model& model, const StateSequence& observation);

enum class Method {
  kBest,   // tree and graphs, then comparison with stored frames
  kPaper,  // tree and graphs only, as in the paper
};

// Stored frames [first, end).
struct FrameRange {
  int first = 0;
  int end = 0;
};

// A stored frame similar to the observation, with its weight.
struct Exemplar {
  int frame = 0;
  double weight = 0;  // weights of a set sum to 1
};

// Returns branches with candidate frames: those the motion is most probably in (`now`, most
// probable first), replaced by their ancestors until they have `min_frames` frames or all are
// included. Counts frames of clips that `mask` allows.
std::vector<int> ExemplarPool(const Model& model, int layer, const std::vector<NodeState>& now,
                              const ClipMask* mask, int min_frames = 512);

// Returns at most `count` stored frames of allowed clips under `branches` that are nearest to a
// scaled state (dimensions; NaN is ignored), except those in `without`. The distance d is the mean
// squared difference over dimensions. Weights are exp(-(d - d_min) / (2 (d_median - d_min))),
// normalised. O(allowed frames under the branches).
std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count, const ClipMask* mask,
                                    FrameRange without = {});

}  // namespace motiondb::core
