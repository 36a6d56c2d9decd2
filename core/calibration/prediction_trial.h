// How well a model predicts its own clips when each is held back: what confidence is fitted to.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

// Predicts at some two hundred moments at most, spread evenly over the clips, each without the clip
// it is of, and at some of them again without the second around them alone, for motion is often
// like what is stored of the same person; and fits an error law to each horizon of a query by
// default. No laws where the database has one clip or the clips are too short. The same for any
// number of threads. CANCELLED.
absl::StatusOr<PredictionConfidence> FitPredictionConfidence(const Model& model,
                                                             const ParallelFor& parallel,
                                                             const BuildProgress& progress);

}  // namespace motiondb::core
