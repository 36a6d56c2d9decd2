// A model with more clips, without a build: their frames go down the tree as it is. Safe to call
// from any thread; uses only the threads lent to it.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "core/model/model.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// The model with `inputs` as its last clips. Each frame goes to the leaf on its side of every
// threshold (section III-B); node statistics and transition graphs count it (eq. 6), the clips are
// found by recognition and prediction as the others are. What is fitted to all motion stays that of
// the last build: scale, thresholds, the metric, the motion prior, familiarity and calibration.
// Memory of the stored states is shared with `base`, which stays as it is. INVALID_ARGUMENT as
// BuildModel; FAILED_PRECONDITION if the base does not know where its tree was divided (built by an
// older version). O(added * depth * dimensions + frames + branches), a fraction of a second where a
// build takes minutes.
absl::StatusOr<Model> ExtendModel(const Model& base, std::vector<BuildInput> inputs,
                                  const ParallelFor& parallel);

// How far a model is from the one that a build of its clips would give. Both in [0, 1].
struct ModelDrift {
  double added = 0;  // share of its frames that came after the build
  double stale = 0;  // see DriftFraction (core/tree/tree_builder.h)

  // Whether it is time to build: more than a tenth of the frames were added, or more than a
  // twentieth lie in nodes that would be divided.
  bool IsLarge() const { return added > 0.1 || stale > 0.05; }
};
ModelDrift MeasureDrift(const Model& model, const ParallelFor& parallel);

}  // namespace motiondb::core
