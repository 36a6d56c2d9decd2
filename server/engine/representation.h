// Converts motion to a database's markers and frame rate, within limits of size and memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/states.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

struct RepresentationLimits {
  double frame_rate_hz = 0;  // of the database
  // At the database's rate and at the motion's own rate, for 34 markers; proportionally fewer for
  // more markers.
  int max_frames = 0;
  WorkOptions terms;
};

// Like core::Represent, within `limits`. RESOURCE_EXHAUSTED if the motion is too long or needs too
// much memory; INVALID_ARGUMENT if its frame rate is too low; CANCELLED; see also IsHeavyWork.
absl::StatusOr<core::StateSequence> RepresentWithin(
    const RepresentationLimits& limits, const core::MarkerScheme& scheme,
    const core::Motion& motion, core::Cleaning cleaning, std::optional<double> leg_length_m,
    std::vector<std::string>* notes = nullptr, core::SourcePart* part = nullptr);

// Checks the size of a motion before its conversion and reserves the memory for that.
// RESOURCE_EXHAUSTED if the motion is too long or needs too much memory; INVALID_ARGUMENT if its
// frame rate is too low or its frames have too many joints; see also IsHeavyWork.
absl::Status CheckSize(const RepresentationLimits& limits, int marker_count,
                       const core::Motion& motion);

// Returns the memory (bytes) of states with their root path.
std::int64_t BytesOfStates(std::int64_t frames, int marker_count);

// Returns the frame rate of the source frames, Hz.
double FrameRate(const core::Motion& motion);

}  // namespace motiondb::server
