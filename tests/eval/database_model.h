// A model as the database would hold it, of a protocol's training clips.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// At the clips' frame rate, with the default settings otherwise.
absl::StatusOr<core::Model> ModelOf(const core::MarkerSet& set, const ClipSet& training);

// Bytes of its states, node statistics, graphs and what is familiar.
double ModelBytes(const core::Model& model);

}  // namespace motiondb::tests
