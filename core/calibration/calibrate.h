// Calibrates the probabilities of a model's answers with held-out stored clips: a calibrated
// probability equals the observed frequency.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Calibrates a model that is built and not yet shared. Uses at most 128 stored clips, to bound the
// time. The result does not depend on the number of threads. CANCELLED if `progress` returns false;
// the model is then unchanged.
absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress);

// Returns the model with everything that depends on labels fitted again: metric, stored frames and
// index in the metric, and the calibration. Tree, node statistics, graphs, scale and motion prior
// stay. For a model without extension it equals BuildModel and Calibrate of the same clips with
// their present labels. CANCELLED if `progress` returns false.
absl::StatusOr<Model> RefitLabels(Model model, const ParallelFor& parallel,
                                  const BuildProgress& progress);

}  // namespace motiondb::core
