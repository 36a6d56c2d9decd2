// State vectors (section III-A, eqs. 1-2): marker positions and velocities in the reference frame,
// divided by the subject's leg length.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/glitches.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// Version of the conversion from motion files to states. Stored states carry it (storage:
// ClipRecord), and one model contains states of one version only: after an upgrade that raises the
// version, the server recomputes the states of stored clips from their files.
//
// Raise it by one, with a line below, if Represent or a reader (core/format) yields different
// states for any file: forward kinematics, the standard marker set and its mappings, the reference
// frame, the size, resampling, velocities, repair of gaps and glitches. The model's own
// computations (scales, tree, statistics) do not count.
//   1  first release
//   2  glitches are handled by the database's policy (glitches.h)
//   3  reference poses at the start are left out, feet and heads can be derived, optical marker
//      sets are mapped by their landmarks
//   4  the leg length of a skeleton is measured in its rest pose
//   5  heights count from the floor under standing feet; joints of DAZ skeletons and of optical
//      markers are nearer to those of Acclaim skeletons
// Mappings that are added to a database are applied to stored clips only on request
// (Engine::ReprocessDatabase).
inline constexpr int kRepresentationVersion = 5;

// frames x 3: x and y of the reference frame's origin in the world (m), and its heading: the angle
// of its x axis about the world's z (rad, unwrapped over time).
using RootPath = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// The states of one motion, before the scaling of a model.
struct StateSequence {
  double frame_rate_hz = 0;
  double leg_length_m = 0;
  // frames x 6 N_v: position (3) and velocity (3) of each marker, in the reference frame, in leg
  // lengths and leg lengths per second. NaN: missing marker.
  FrameMatrix states;
  RootPath root_path;  // frames x 3
  // Frames that glitches affect, ascending and disjoint (GlitchPolicy::kKeep).
  std::vector<FrameSpan> glitches = {};
  // Height (m) in the world of the floor from which states count. 0 in stored clips: they are moved
  // to their floor.
  double floor_m = 0;

  int frame_count() const { return static_cast<int>(states.rows()); }
};

// Returns the leg length (m), hip to knee to ankle: median over frames, mean over the set's
// complete legs. Without legs: half the markers' median height above the lowest marker.
// INVALID_ARGUMENT if no frame has the necessary markers.
absl::StatusOr<double> EstimateLegLength(const MarkerSet& set, const MarkerMotion& motion);

// Returns the leg length (m) of a skeleton, hip to knee to ankle, at zero angles, by the scheme's
// mapping. So it does not depend on the pose. INVALID_ARGUMENT if no mapping fits the skeleton or
// its size cannot be estimated.
absl::StatusOr<double> SkeletonLegLength(const MarkerScheme& scheme,
                                         const std::shared_ptr<const Skeleton>& skeleton);

// Returns the reference frame of each frame: origin on the floor below the middle of the hips, x to
// the front (the line from right to left hip, turned by -90 degrees on the floor). Interpolated if
// a hip is missing or the hip line is nearly vertical. INVALID_ARGUMENT if no frame has both hips.
absl::StatusOr<RootPath> ReferenceFrames(const MarkerSet& set, const MarkerMotion& motion);

// Returns the motion at another frame rate, with the same duration, by cubic interpolation (linear
// next to missing markers). INVALID_ARGUMENT if the rate is not positive or the motion has fewer
// than two frames.
absl::StatusOr<MarkerMotion> Resample(const MarkerMotion& motion, double frame_rate_hz);

// Fills gaps (runs of frames with a missing marker) of at most `max_gap_seconds` by linear
// interpolation; gaps at the ends get the nearest value. INVALID_ARGUMENT, with marker and frames,
// if a gap is longer. Returns one note for each filled marker.
absl::StatusOr<std::vector<std::string>> FillGaps(double max_gap_seconds, MarkerMotion& motion);

// Returns the states of a motion on the set's markers. Velocities are central differences,
// one-sided at the ends and next to missing markers. INVALID_ARGUMENT as for the functions above.
absl::StatusOr<StateSequence> ComputeStates(const MarkerSet& set, const MarkerMotion& motion,
                                            std::optional<double> leg_length_m = std::nullopt);

// How Represent cleans a motion. Stored clips have no gaps, and glitches only if the database keeps
// them. Observations keep NaN, which emission ignores, and the times of their frames: only a
// reference pose at the start is replaced (ReplacePoseAtStart).
using Cleaning = std::optional<GlitchPolicy>;
inline constexpr Cleaning kObservation = std::nullopt;

// The frames of a motion from which states were computed.
struct SourcePart {
  int first_frame = 0;  // of the motion, from 0
  int frame_count = 0;  // at its own rate
  double floor_m = 0;   // height of the floor, which the states have at z = 0
};

// Converts a motion to states. Without `leg_length_m`, the size of joints is measured on their
// bones with all rotations zero, and that of markers is estimated. Steps: ApplyScheme, glitches,
// gaps, MoveToFloor (motion_floor.h), Resample, ComputeStates. Appends to `notes`, if not null, the
// glitches and gaps that were found, and sets `part`, if not null. CANCELLED soon after `cancelled`
// returns true.
absl::StatusOr<StateSequence> Represent(const MarkerScheme& scheme, const Motion& motion,
                                        double frame_rate_hz, Cleaning cleaning,
                                        std::optional<double> leg_length_m = std::nullopt,
                                        std::vector<std::string>* notes = nullptr,
                                        const Cancelled& cancelled = {},
                                        SourcePart* part = nullptr);

// Returns the marker positions in the world (m, z up), frames x 3 N_v: the inverse of
// ComputeStates.
FrameMatrix WorldPositions(const StateSequence& sequence);

// Returns the last frames up to and including `frame`: `history` of them, fewer at the beginning,
// at least one. Velocities of the last frame become backward differences, because the next frame
// must stay unknown.
StateSequence PastAt(const StateSequence& observation, int frame, int history);

}  // namespace motiondb::core
