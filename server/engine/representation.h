// Brings motion to a database's markers and frame rate, with a limit on what comes of it. Safe to
// call from any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::server {

// What may be done at once, beside other calls: what is over within moments, or all that the limits
// allow.
enum class Allowed { kLightWork, kAllWork };

// How much may be done, until when and with how much memory.
struct WorkTerms {
  Allowed allowed = Allowed::kAllWork;
  core::Cancelled cancelled;
  // Reserves the memory (bytes) that the work may take from here on, in place of what was reserved
  // for it before. Empty: there is no limit.
  std::function<absl::Status(std::int64_t)> reserve = {};
  // When the caller gives up; far away where the caller set no time.
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();

  // RESOURCE_EXHAUSTED.
  absl::Status Reserve(std::int64_t bytes) const {
    return reserve ? reserve(bytes) : absl::OkStatus();
  }
};

// An observation or clip has at least one frame for so many of the database's. Between frames that
// are further apart there is nothing but interpolation, and a few bytes would become hours.
inline constexpr double kMostFramesForOne = 32;

struct RepresentationLimits {
  double frame_rate_hz = 0;  // of the database
  // At that rate, and of the motion at its own; of 34 markers, of more markers as many fewer.
  int max_frames = 0;
  WorkTerms terms;
};

// Whether a motion was not represented because that is heavy work, which was not allowed.
bool IsHeavyWork(const absl::Status& status);

// As core::Represent, within the memory that the terms give. RESOURCE_EXHAUSTED for a motion that
// lasts too long or takes too much memory; INVALID_ARGUMENT for a frame rate too low. CANCELLED.
absl::StatusOr<core::StateSequence> RepresentWithin(const RepresentationLimits& limits,
                                                    const core::MarkerScheme& scheme,
                                                    const core::Motion& motion,
                                                    core::Cleaning cleaning,
                                                    std::optional<double> leg_length_m,
                                                    std::vector<std::string>* notes = nullptr);

// Before a motion becomes the markers of a set, at the limits' frame rate; reserves the memory for
// that. RESOURCE_EXHAUSTED for a motion that lasts too long or takes too much memory,
// INVALID_ARGUMENT for one with a frame rate too low or with more joints in its frames than can be
// placed; IsHeavyWork.
absl::Status CheckSize(const RepresentationLimits& limits, int marker_count,
                       const core::Motion& motion);

// Memory (bytes) of states with their root path.
std::int64_t BytesOfStates(std::int64_t frames, int marker_count);

// Frame rate of the motion's own frames.
double FrameRate(const core::Motion& motion);

}  // namespace motiondb::server
