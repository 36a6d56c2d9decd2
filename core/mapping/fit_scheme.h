// Chooses the mapping of a motion: one of the scheme's, or an automatic one.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// Returns the scheme if one of its mappings fits the motion. Otherwise, if its set is standard34,
// returns the set with an automatic mapping of this motion (core/mapping/automatic_mapping.h), and
// appends to `note`, if not null, how it was found. INVALID_ARGUMENT if there is no mapping: what
// was found, and what to do. O(joints) for each of 24 frames.
absl::StatusOr<MarkerScheme> FitScheme(const MarkerScheme& scheme, const Motion& motion,
                                       std::string* note = nullptr);

}  // namespace motiondb::core
