// Parts of motion as observations.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"
#include "tests/eval/peers/peer.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

inline constexpr double kWindowSeconds = 0.4;
inline constexpr double kHopSeconds = 0.1;

// Returns frames [first, first + count).
core::StateSequence Slice(const core::StateSequence& states, int first, int count);
core::MarkerMotion Slice(const core::MarkerMotion& markers, int first, int count);

// Returns windows of 0.4 s every 0.1 s; a shorter motion is one window.
std::vector<core::StateSequence> SplitIntoWindows(const core::StateSequence& states);

// Returns the windows, or the whole as one part.
std::vector<core::StateSequence> SplitIntoParts(const core::StateSequence& states, Extent extent);

// Returns the states of markers at another frame rate, for a body of known size.
absl::StatusOr<core::StateSequence> StatesOf(const core::MarkerSet& set,
                                             const core::MarkerMotion& markers,
                                             double frame_rate_hz, double leg_length_m);

// Returns the first `share` of a clip's frames (at least two). Later frames are not used: the last
// velocities are backward differences. The size of the body is known.
absl::StatusOr<core::StateSequence> PrefixStates(const core::MarkerSet& set, const EvalClip& clip,
                                                 double share);

}  // namespace motiondb::tests
