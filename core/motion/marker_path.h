// One marker's way through a recording, and which frames of it one body cannot pass through. Plain
// values; functions are safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::core {

// frames x 3, m; NaN where there is no position.
using MarkerPath = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// In metres and seconds.
struct PathLimits {
  double speed = 0;
  double acceleration = 0;
  double velocity_change = 0;  // from a frame to the next
  double least_deviation = 0;  // what is less is no fault
};

// Runs of at least three frames and 0.05 s in which the position is the same to the last digit.
std::vector<FrameSpan> StillRuns(const MarkerPath& path, double frame_rate_hz);

struct PathFaults {
  std::vector<FrameSpan> outside;  // of the longest chain of pieces that a body can pass through
  std::vector<int> suspects;  // frames that a step leads to which is near the limits, or beyond
};

// A step is impossible if it is too fast, or sticks out from the steps before and after by more
// than the acceleration allows; a single bend, as of a foot that hits something, does not. Pieces
// end at impossible steps, at steps of 0.2 times that, where what began with an impossible one may
// end, at missing frames, and about each of `doubtful`. Those count for nothing in the length of a
// chain: they are in it only if they fit. O(frames) plus 64 for each piece.
PathFaults FindPathFaults(const MarkerPath& path, double frame_rate_hz, const PathLimits& limits,
                          const std::vector<FrameSpan>& doubtful);

// Markers of one body segment keep their distances: whatever the frame rate, that tells a marker
// that is out of place. Pure; safe to call from any thread.

// Of each marker, the frames in which it has left its segment: the three nearest markers, or two,
// within half a leg length whose distances to it vary by at most 0.04 leg lengths in 95 of 100
// frames. A distance is wrong if it is further from its median than 0.1 leg lengths and four times
// that variation; a marker has left its segment where two of its distances are wrong. The one whose
// distances are most wrong is at fault; then the others are looked at without it. In a calm clip
// that finds limbs that move for once, too: callers look for an abrupt beginning or end. O(frames *
// markers + markers^2).
std::vector<std::vector<FrameSpan>> FramesOffSegment(const MarkerMotion& motion,
                                                     double leg_length_m);

}  // namespace motiondb::core
