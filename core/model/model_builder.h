// Builds a model from the states of clips: scale, tree, node statistics, graphs, familiarity.
// Safe to call from any thread; uses only the threads lent to it.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "core/model/model.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Called now and then from the calling thread with progress in [0, 1] and what is being done.
// Returns false to stop the build, which then ends as CANCELLED.
using BuildProgress = std::function<bool(double fraction, std::string_view stage)>;

// The same inputs in the same order give the same model, bit for bit, on any number of threads.
// INVALID_ARGUMENT as CheckInputs.
absl::StatusOr<Model> BuildModel(const BuildSettings& settings, const MarkerSet& marker_set,
                                 std::vector<BuildInput> inputs, const ParallelFor& parallel,
                                 const BuildProgress& progress);

}  // namespace motiondb::core
