// Changes the labels of a model without a build.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"

namespace motiondb::core {

// Returns the model with new labels and subjects, one for each clip. Recognition then names the new
// labels; metric and calibration stay those learned from the old ones until RefitLabels
// (core/calibration/refit_labels.h) or a build. Shares the stored states with `base`; copies the
// rest. INVALID_ARGUMENT as LabelTracks::Check, naming the clip, or if the number of clips differs.
absl::StatusOr<Model> WithLabels(const Model& base, std::vector<ClipLabels> labels);

}  // namespace motiondb::core
