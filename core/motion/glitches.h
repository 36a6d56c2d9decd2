// Glitches: frames in which a marker is where no body can bring it. Detected once, at ingest, on
// the frames of the source.
//
// Lengths are in leg lengths (hip to knee to ankle, 0.49 of the stature: Winter, "Biomechanics and
// Motor Control of Human Movement", after Drillis and Contini), so that limits apply to all body
// sizes. Values in metres are for a leg of 0.85 m.
//
// Limits, well above values reported for athletes (rounded, orders of magnitude):
// - marker speed: 40 /s = 34 m/s (thrown javelins: 30 m/s);
// - marker acceleration: 1200 /s^2 = 1000 m/s^2 (hands and feet in punches and kicks: 50 to 100 g);
// - marker velocity change between frames: 25 /s = 21 m/s (a foot at 20 m/s that hits a ball);
// - acceleration of the whole body: 180 /s^2 = 150 m/s^2 (hard landings: 10 to 15 body weights);
// - velocity change of the whole body: 15 /s = 13 m/s (a sprinter at 12 m/s who stops);
// - change of distance within a segment: 0.1 = 8.5 cm. Skin moves over the bone by some
//   centimetres, mostly at the thigh (review: Leardini, Chiari, Della Croce and Cappozzo, Gait and
//   Posture 21, 2005, pages 212 to 225).
//
// Deviations below 0.2 leg lengths (17 cm) are ignored: inverse kinematics solvers flip hands and
// toes by up to 16 cm in one frame of good recordings. Each limit is increased by the noise of the
// recording, five times the marker's median second difference. Noise and velocity change make the
// limits wide enough at low frame rates.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"

namespace motiondb::core {

enum class GlitchKind {
  kJump,       // arrives or leaves faster than a body moves
  kOrigin,     // jumps to exactly the origin
  kFrozen,     // bitwise constant, then jumps
  kSwapped,    // exchanged with another marker
  kStretched,  // leaves the markers of its segment
  kBeyond,     // a coordinate exceeds 100 km
};

struct Glitch {
  int marker = kAllMarkers;
  int first_frame = 0;  // from 0
  int last_frame = 0;
  GlitchKind kind = GlitchKind::kJump;
  int swapped_with = -1;  // marker, for kSwapped

  static constexpr int kAllMarkers = -1;
  friend bool operator==(const Glitch&, const Glitch&) = default;
};

// Returns the glitches of a motion, ordered by frame and marker. Missing markers are NaN; frame
// rates from 1 to 1000 Hz. Positions are relative to the world point `origin` (m). Below about 15
// Hz only deviations of metres are found. If a motion jumps and does not return, the shorter part
// is the glitch. O(frames * markers + markers^2). REQUIRES: leg_length_m > 0.
std::vector<Glitch> FindGlitches(const MarkerMotion& motion, double leg_length_m,
                                 const Eigen::Vector2d& origin = Eigen::Vector2d::Zero());

// Returns text such as "frames 12-15: 'LWrist' jumps"; frames of the file, counted from 1.
std::string Describe(const Glitch& glitch, const MarkerMotion& motion);

// What ingest does with the glitches of a clip: a setting of the database.
enum class GlitchPolicy {
  kRepair,  // interpolate up to kMaxRepairSeconds, reject longer ones
  kReject,  // reject the clip
  kDrop,    // store the longest part without glitches
  kKeep,    // store the clip unchanged
};

inline constexpr double kMaxRepairSeconds = 0.25;

// Prefix of the note on glitches in a clip's report.
inline constexpr char kGlitchNote[] = "glitches ";

// Applies the policy: repaired positions become NaN (filled later), dropped frames are removed.
// Returns the frames of the remaining glitches, ascending and disjoint; empty unless kKeep. Appends
// one note if there are glitches. INVALID_ARGUMENT, with frame and marker of the first rejected
// glitch, if the clip is rejected. REQUIRES: `glitches` are those of `motion`.
absl::StatusOr<std::vector<FrameSpan>> ApplyGlitchPolicy(GlitchPolicy policy,
                                                         const std::vector<Glitch>& glitches,
                                                         MarkerMotion& motion,
                                                         std::vector<std::string>& notes);

// Returns the frames that the spans affect after resampling to `to_hz` (`frame_count` frames) and
// differentiation, ascending and disjoint.
std::vector<FrameSpan> AtFrameRate(const std::vector<FrameSpan>& spans, double from_hz,
                                   double to_hz, int frame_count);

}  // namespace motiondb::core
