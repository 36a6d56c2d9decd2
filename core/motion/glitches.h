// Glitches: stretches of a recording in which a marker is where no body can bring it. Found once,
// at ingest, on the source's own frames. Pure; safe to call from any thread.
//
// Lengths are in leg lengths (hip to knee to ankle, 0.49 of the stature: Winter, "Biomechanics and
// Motor Control of Human Movement", after Drillis and Contini), so that the limits hold for every
// body size. In metres they are given for a leg of 0.85 m.
//
// The limits, each well above what athletes are reported to reach (rounded, orders of magnitude):
// - a marker: 40 /s = 34 m/s (thrown javelins: 30 m/s);
// - 1200 /s^2 = 1000 m/s^2 (hands and feet in punches and kicks: 50 to 100 g);
// - 25 /s = 21 m/s from frame to frame (a foot at 20 m/s that stops at a ball);
// - the body as a whole: 180 /s^2 = 150 m/s^2 (hard landings: 10 to 15 body weights);
// - 15 /s = 13 m/s from frame to frame (a sprinter's 12 m/s, to rest);
// - the distance of two markers of one segment: 0.1 = 8.5 cm. Skin moves over the bone, most at the
//   thigh, by some centimetres (the review of Leardini, Chiari, Della Croce and Cappozzo, Gait and
//   Posture 21, 2005, pages 212 to 225, has the measurements).
//
// Deviations below 0.2 leg lengths (17 cm) are passed over: solvers of joint angles flip hands and
// toes by up to 16 cm in a frame, in recordings that are good otherwise. To each limit comes the
// noise of the recording itself, five times the median second difference of the marker. That, and
// the change of velocity, make the limits as wide as a low frame rate needs.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"

namespace motiondb::core {

enum class GlitchKind {
  kJump,       // it gets there, or away again, faster than a body moves
  kOrigin,     // it lies exactly at the origin, and jumps there
  kFrozen,     // it stands still to the last digit, and then jumps
  kSwapped,    // it has another marker's place, and that has its
  kStretched,  // it leaves the markers of its own segment
  kBeyond,     // a coordinate is more than 100 km
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

// The glitches of a motion, whose missing markers are NaN, in order of frame and marker. Frame
// rates from 1 to 1000 Hz. `origin` (m) is the world's point that positions are relative to. Below
// some 15 Hz only what is metres away is found. Where a motion jumps and stays there, the
// shorter part is the glitch. O(frames * markers + markers^2). REQUIRES: leg_length_m > 0.
std::vector<Glitch> FindGlitches(const MarkerMotion& motion, double leg_length_m,
                                 const Eigen::Vector2d& origin = Eigen::Vector2d::Zero());

// "frames 12-15: 'LWrist' jumps"; frames are counted from 1.
std::string Describe(const Glitch& glitch, const std::vector<std::string>& marker_names);

// What becomes of a clip's glitches (core/motion/glitches.h) when it is ingested: a setting of the
// database. Safe to call from any thread.
enum class GlitchPolicy {
  kRepair,  // interpolate over up to kLongestRepairSeconds, refuse longer ones
  kReject,  // refuse the clip
  kDrop,    // store the longest stretch without glitches
  kKeep,    // store it as it is
};

inline constexpr double kLongestRepairSeconds = 0.25;

// How the note on glitches in a clip's report begins.
inline constexpr char kGlitchNote[] = "glitches ";

// Changes the motion as the policy says: repaired places become missing (NaN), dropped frames go.
// Returns the frames of glitches that stay, in order and apart: none but by kKeep. `notes` gets one
// on what was found, if anything was. INVALID_ARGUMENT, with frame and marker of the first glitch
// that stands in the way, for a clip that is refused. REQUIRES: the glitches are the motion's.
absl::StatusOr<std::vector<FrameSpan>> ApplyGlitchPolicy(GlitchPolicy policy,
                                                         const std::vector<Glitch>& glitches,
                                                         MarkerMotion& motion,
                                                         std::vector<std::string>& notes);

// The frames that any of the spans touches once the motion is resampled and has velocities, of
// `frame_count` frames; in order and apart.
std::vector<FrameSpan> AtFrameRate(const std::vector<FrameSpan>& spans, double from_hz,
                                   double to_hz, int frame_count);

}  // namespace motiondb::core
