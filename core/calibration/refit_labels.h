// Learns a model's labels again, without a build.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Returns the model with everything that depends on labels fitted again: metric, stored frames and
// index in the metric, and the calibration. Tree, node statistics, graphs, scale and motion prior
// stay. For a model without extension it equals BuildModel and Calibrate of the same clips with
// their present labels. CANCELLED if `progress` returns false.
absl::StatusOr<Model> RefitLabels(Model model, const ParallelFor& parallel,
                                  const BuildProgress& progress);

}  // namespace motiondb::core
