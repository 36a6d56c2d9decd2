// What every query does with its observation first, and how it may be answered.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// The observation's states (frames x dimensions), scaled as the model's. INVALID_ARGUMENT if it is
// empty, has another marker set or frame rate than the model, or an infinite number.
absl::StatusOr<FrameMatrix> ScaledObservation(const Model& model, const StateSequence& observation);

enum class Method {
  kBest,   // the tree and its graphs, then stored frames compared with the observation
  kPaper,  // the tree and its graphs alone, as in the paper
};

// Stored frames taken as examples of what is observed. Safe to call from any thread.
class Model;

// Stored frames [first, end).
struct FrameRange {
  int first = 0;
  int end = 0;
};

// A stored frame, and how much it counts.
struct Exemplar {
  int frame = 0;
  double weight = 0;  // weights of a set sum to 1
};

// Branches whose frames may serve: those the motion is most probably in (`now`, most probable
// first), and then their ancestors until there are at least so many frames, if there are as many.
std::vector<int> ExemplarPool(const Model& model, int layer, const std::vector<NodeState>& now,
                              int least_frames = 512);

// The stored frames nearest to a scaled state (dimensions, NaN left out) among those under
// `branches`, at most `count`, weighted by closeness. The mean squared difference a dimension is
// the distance; the weight falls to exp(-1/2) at the distance of the median exemplar. Frames in
// `without` are passed over. O(frames under the branches).
std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count, FrameRange without = {});

}  // namespace motiondb::core
