// State vectors (section III-A, eqs. 1-2): marker positions and velocities in the reference frame,
// divided by the subject's size. Plain values; functions are safe to call from any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// frames x 3: x and y of the reference frame's origin in the world (m), and its heading, the angle
// of its x axis about the world's z (rad, unwrapped over time).
using RootPath = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// The states of one motion, not yet scaled by a model.
struct StateSequence {
  double frame_rate_hz = 0;
  double leg_length_m = 0;
  // frames x 6 N_v: for each marker position (3) then velocity (3), in the reference frame, in leg
  // lengths and leg lengths per second. NaN where a marker was missing.
  FrameMatrix states;
  RootPath root_path;  // frames x 3

  int frame_count() const { return static_cast<int>(states.rows()); }
};

// Leg length (m): hip to knee to ankle, median over frames, mean of the set's whole legs; where the
// set has none, half the markers' median height above the lowest point.
// INVALID_ARGUMENT if no frame has the markers for it.
absl::StatusOr<double> EstimateLegLength(const MarkerSet& set, const MarkerMotion& motion);

// The reference frame of each frame: origin on the floor below the middle of the hips, x to the
// front (the line from right to left hip, turned by -90 degrees on the floor). Where the hips are
// missing or one is above the other it is interpolated. INVALID_ARGUMENT if no frame has both hips.
absl::StatusOr<RootPath> ReferenceFrames(const MarkerSet& set, const MarkerMotion& motion);

// The motion at another frame rate, by cubic interpolation (linear beside missing markers), over
// the same time. INVALID_ARGUMENT for a rate that is not positive or a motion without two frames.
absl::StatusOr<MarkerMotion> Resample(const MarkerMotion& motion, double frame_rate_hz);

// Fills runs of missing markers, at most `max_gap_seconds` long, by linear interpolation (held at
// the ends). INVALID_ARGUMENT naming marker and frames where a run is longer. Returns one note a
// marker.
absl::StatusOr<std::vector<std::string>> FillGaps(double max_gap_seconds, MarkerMotion& motion);

// States of a motion on the set's markers: velocities by central differences, one-sided at the ends
// and beside missing markers. INVALID_ARGUMENT as for the functions above.
absl::StatusOr<StateSequence> ComputeStates(const MarkerSet& set, const MarkerMotion& motion,
                                            std::optional<double> leg_length_m = std::nullopt);

// What happens to missing markers in Represent.
enum class Gaps {
  kFill,  // stored clips: fill short gaps, refuse long ones
  kKeep,  // observations: leave NaN, which emission passes over
};

// The whole way from a motion to states: gaps, ApplyScheme, Resample, ComputeStates. `notes`, where
// given, receives what was filled. CANCELLED, soon after `cancelled` says so.
absl::StatusOr<StateSequence> Represent(const MarkerScheme& scheme, const Motion& motion,
                                        double frame_rate_hz, Gaps gaps,
                                        std::optional<double> leg_length_m = std::nullopt,
                                        std::vector<std::string>* notes = nullptr,
                                        const Cancelled& cancelled = {});

// Marker positions in the world (m, z up), frames x 3 N_v: the way back from states.
FrameMatrix WorldPositions(const StateSequence& sequence);

}  // namespace motiondb::core
