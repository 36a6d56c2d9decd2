// Brings motion to a database's markers and frame rate, with a limit on what comes of it. Safe to
// call from any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/states.h"

namespace motiondb::server {

struct RepresentationLimits {
  double frame_rate_hz = 0;  // of the database
  int max_frames = 0;        // at that rate, and of the motion at its own
};

// As core::Represent. INVALID_ARGUMENT also for a motion that lasts too long: a file of a few bytes
// can claim to last a century.
absl::StatusOr<core::StateSequence> RepresentWithin(const RepresentationLimits& limits,
                                                    const core::MarkerScheme& scheme,
                                                    const core::Motion& motion, core::Gaps gaps,
                                                    std::optional<double> leg_length_m,
                                                    std::vector<std::string>* notes = nullptr);

// INVALID_ARGUMENT for a motion of more frames of its own, each of which becomes all the markers of
// a set, or of more joints in them than can be placed.
absl::Status CheckFrameCount(const core::Motion& motion, int max_frames);

// Frame rate of the motion's own frames.
double FrameRate(const core::Motion& motion);

}  // namespace motiondb::server
