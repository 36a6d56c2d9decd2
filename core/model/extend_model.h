// Extension: adds clips to a model without a build. Their frames descend the existing tree.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "core/model/model.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Returns the model with `inputs` appended. Each frame descends the tree by the thresholds (section
// III-B) and is counted in node statistics and transition graphs (eq. 6). The scale, the
// thresholds, the metric, the motion prior, the familiarity and the calibration do not change.
// Shares the memory of the stored states with `base`, which does not change. INVALID_ARGUMENT as
// BuildModel; FAILED_PRECONDITION if the base has no split thresholds (built by an older version).
// O(added * depth * dimensions + frames + branches).
absl::StatusOr<Model> ExtendModel(const Model& base, std::vector<BuildInput> inputs,
                                  const ParallelFor& parallel);

// Difference between a model and a build of the same clips. Fractions, 0 to 1.
struct ModelDrift {
  double added = 0;  // fraction of frames added after the build
  double stale = 0;  // see DriftFraction (core/tree/tree_builder.h)

  // Returns whether a build is needed: more than 10 % of the frames were added, or more than 5 %
  // are in nodes that a build would split.
  bool IsLarge() const { return added > 0.1 || stale > 0.05; }
};
ModelDrift MeasureDrift(const Model& model, const ParallelFor& parallel);

}  // namespace motiondb::core
