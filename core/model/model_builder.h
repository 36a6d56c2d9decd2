// Builds a model from the states of clips: scale, tree, node statistics, graphs, familiarity,
// motion prior, metric.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "core/model/model.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Called repeatedly on the calling thread with the progress (0 to 1) and the current stage. Returns
// false to cancel the build.
using BuildProgress = std::function<bool(double fraction, std::string_view stage)>;

// Returns the model of the clips. It depends only on the inputs and their order, not on the number
// of threads. INVALID_ARGUMENT as CheckInputs; CANCELLED.
absl::StatusOr<Model> BuildModel(const BuildSettings& settings, const MarkerSet& marker_set,
                                 std::vector<BuildInput> inputs, const ParallelFor& parallel,
                                 const BuildProgress& progress);

}  // namespace motiondb::core
