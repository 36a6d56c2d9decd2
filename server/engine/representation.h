// Converts motion to a database's markers and frame rate, within limits of size and memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::server {

class ChangeSignal;

// AllowedWork work: only light work, which ends within moments, or all work within the limits.
enum class AllowedWork { kLightWork, kAllWork };

// Limits of the work for a call: amount, time and memory.
struct WorkOptions {
  AllowedWork allowed = AllowedWork::kAllWork;
  core::Cancelled cancelled;
  // Sets the memory reservation (bytes) for the rest of the work; replaces the previous one. Empty:
  // no limit.
  std::function<absl::Status(std::int64_t)> reserve = {};
  // Deadline of the caller; max() if the caller set none.
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  // Runs the work again after the next change that `signal` reports, if the work then returns
  // AwaitsChange. Empty: the caller cannot wait.
  std::function<void(ChangeSignal& signal)> wake_on = {};

  // RESOURCE_EXHAUSTED.
  absl::Status Reserve(std::int64_t bytes) const {
    return reserve ? reserve(bytes) : absl::OkStatus();
  }
};

struct RepresentationLimits {
  double frame_rate_hz = 0;  // of the database
  // At the database's rate and at the motion's own rate, for 34 markers; proportionally fewer for
  // more markers.
  int max_frames = 0;
  WorkOptions terms;
};

// Returns the status with which light work refuses heavy work.
absl::Status HeavyWork();

// Returns whether a conversion was refused because it is heavy work and only light work is allowed.
bool IsHeavyWork(const absl::Status& status);

// Returns the status of work that cannot go on before a database changes; see WorkOptions::wake_on.
absl::Status AwaitsChange();
bool IsAwaitingChange(const absl::Status& status);

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
