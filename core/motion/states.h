// State vectors (section III-A, eqs. 1-2): marker positions and velocities in the reference frame,
// divided by the subject's size. Plain values; functions are safe to call from any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/glitches.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// The version of what makes states of a motion file. Stored states carry it (storage: ClipRecord),
// and states of different versions are never in one model: after an upgrade that raises it, the
// server derives the stored clips again from their files.
//
// Raise it by one, with a line below, with every change after which Represent or a reader
// (core/format) gives other states for some file: forward kinematics, the standard marker set and
// its mappings, the reference frame, what sizes are divided by, resampling, velocities, repair of
// gaps and glitches. What a model makes of states (scales, tree, statistics) is no part of it.
//   1  as first released
//   2  glitches are repaired, or what else the database's setting says (glitch_policy.h)
// A setting of a database that changes while it has clips, such as its mappings, needs a number of
// its own: beside this one in ClipRecord, compared wherever this one is.
inline constexpr int kRepresentationVersion = 2;

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
  // Frames that glitches of the recording reach, in order and apart (GlitchPolicy::kKeep).
  std::vector<FrameSpan> glitches = {};

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

// How a motion is cleaned in Represent: a clip that is stored has no gaps and no glitches but those
// that its database keeps; an observation stays as it is, with NaN, which emission passes over.
using Cleaning = std::optional<GlitchPolicy>;
inline constexpr Cleaning kObservation = std::nullopt;

// The whole way from a motion to states: ApplyScheme, glitches, gaps, Resample, ComputeStates.
// `notes`, where given, receives what was found and filled. CANCELLED, soon after `cancelled` says
// so.
absl::StatusOr<StateSequence> Represent(const MarkerScheme& scheme, const Motion& motion,
                                        double frame_rate_hz, Cleaning cleaning,
                                        std::optional<double> leg_length_m = std::nullopt,
                                        std::vector<std::string>* notes = nullptr,
                                        const Cancelled& cancelled = {});

// Marker positions in the world (m, z up), frames x 3 N_v: the way back from states.
FrameMatrix WorldPositions(const StateSequence& sequence);

// The last `history` frames, at least one, up to `frame` (fewer at the beginning). Velocities of
// the last frame must not know the next one: they become backward differences.
StateSequence PastAt(const StateSequence& observation, int frame, int history);

}  // namespace motiondb::core
