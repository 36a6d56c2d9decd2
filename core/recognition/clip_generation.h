// How probable it is that each clip's graph generates a window (section IV-B). Safe to call from
// any thread.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_emission.h"

namespace motiondb::core {

// One score for each of `clips` (indices into Model::clips()), in their order: eq. 7 with eq. 8's
// posterior, on the layer that `emission` is of. CANCELLED, soon.
absl::StatusOr<std::vector<ClipScore>> ScoreGeneration(const Model& model, int layer,
                                                       const WindowEmission& emission,
                                                       const std::vector<int>& clips,
                                                       const RecognizeOptions& options,
                                                       const Cancelled& cancelled);

// Most probable first; equals stay in order.
void SortByGeneration(std::vector<ClipScore>& scores);

}  // namespace motiondb::core
