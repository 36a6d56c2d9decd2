// Finds out on stored clips, each held out in turn, what a model's answers are worth, so that its
// probabilities are frequencies. Safe to call from any thread; uses only the threads lent to it.
#pragma once

#include "absl/status/status.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

// Calibrates a model that was built and is not yet shared. Bounded work: at most some hundred
// stored clips are asked about. The same model for any number of threads. CANCELLED if `progress`
// returns false; the model is then as it was.
absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress);

}  // namespace motiondb::core
