// Parts of motion as observations. Safe to call from any thread.
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

// Frames [first, first + count).
core::StateSequence Slice(const core::StateSequence& states, int first, int count);
core::MarkerMotion Slice(const core::MarkerMotion& markers, int first, int count);

// Windows of 0.4 s every 0.1 s; a shorter motion is one window.
std::vector<core::StateSequence> WindowsOf(const core::StateSequence& states);

// The windows, or the whole as one.
std::vector<core::StateSequence> PartsOf(const core::StateSequence& states, Extent extent);

// The states of markers at another frame rate on a body of known size.
absl::StatusOr<core::StateSequence> StatesOf(const core::MarkerSet& set,
                                             const core::MarkerMotion& markers,
                                             double frame_rate_hz, double leg_length_m);

// The first share of a clip's frames (at least two), and nothing of what comes after: velocities at
// its end are backward differences. The size of the body is known.
absl::StatusOr<core::StateSequence> BeginningOf(const core::MarkerSet& set, const EvalClip& clip,
                                                double share);

}  // namespace motiondb::tests
