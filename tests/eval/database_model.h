// The model that the database has for a protocol's training clips.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// Uses the clips' frame rate and default settings.
absl::StatusOr<core::Model> BuildEvalModel(const core::MarkerSet& set, const ClipSet& training);

// Returns the bytes of its states, node statistics, graphs and familiarity statistics.
double ModelBytes(const core::Model& model);

}  // namespace motiondb::tests
