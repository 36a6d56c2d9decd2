// Where a plan begins among the stored frames. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/plan.h"

namespace motiondb::core {

class Model;

// A stored frame to go on from, and the state that the motion really begins in, which fades into
// it.
struct PlanOrigin {
  int frame = 0;
  Eigen::RowVectorXf state;  // 1 x 6 N_v, in leg lengths, as in a StateSequence; NaN where missing
  double leg_length_m = 0;   // of who begins
};

// For a moment of a clip that is its own frame; for an observation the frame most like its last
// one, by place and velocity of all markers; for standing the one that moves least. Only frames of
// clips with one of `labels` (empty: all) and with half a second to go, if their clip is that long:
// any other moment of a clip begins at the frame most like it.
//
// NOT_FOUND for a clip that the model does not have; OUT_OF_RANGE for a moment outside the clip;
// INVALID_ARGUMENT if no clip has such a label or the observation does not fit the model.
// O(frames * dimensions).
//
// After the best, the best of other clips follow, at most five in all, where the start is not a
// stored frame to be played itself: some lead nowhere.
absl::StatusOr<std::vector<PlanOrigin>> FindOrigins(const Model& model, const PlanStart& start,
                                                    const std::vector<std::string>& labels);

}  // namespace motiondb::core
