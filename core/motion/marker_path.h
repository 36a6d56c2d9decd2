// Trajectory of one marker, and its frames that are physically impossible for a body.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::core {

// frames x 3, m; NaN: missing.
using MarkerPath = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// In metres and seconds.
struct PathLimits {
  double speed = 0;
  double acceleration = 0;
  double velocity_change = 0;  // from one frame to the next
  double min_deviation = 0;    // smaller deviations are not faults
};

// Returns the runs of at least three frames and 0.05 s with bitwise identical positions.
std::vector<FrameSpan> StillRuns(const MarkerPath& path, double frame_rate_hz);

struct PathFaults {
  std::vector<FrameSpan> outside;  // not in the longest feasible chain of pieces
  std::vector<int> suspects;       // frames after a step near or beyond the limits
};

// Finds the longest chain of path pieces that a body can follow; the other frames are faults.
// A step is impossible if it is too fast, or deviates from both adjacent steps by more than the
// acceleration limit; a single change of velocity, such as a foot that hits something, is possible.
// The path is cut at impossible steps, at steps above 0.2 times the limits (an impossible motion
// may end there), at missing frames, and around each span of `doubtful`. Doubtful pieces add almost
// nothing to the length of a chain: they belong to it only if they fit. O(frames) plus 64 for each
// piece.
PathFaults FindPathFaults(const MarkerPath& path, double frame_rate_hz, const PathLimits& limits,
                          const std::vector<FrameSpan>& doubtful);

// Returns, for each marker, the frames in which it is off its body segment. Works at any frame
// rate.
// Partners of a marker are its two or three nearest markers within half a leg length whose distance
// varies by at most 0.04 leg lengths in 95 % of the frames. A distance is wrong if it differs from
// its median by more than 0.1 leg lengths and four times that variation. A marker is off its
// segment if two of its distances are wrong. The marker with the largest total error is at fault;
// then the rest is checked without it. Unusual limb motion in a calm clip is found too, so callers
// check for an abrupt begin or end. O(frames * markers + markers^2).
std::vector<std::vector<FrameSpan>> FramesOffSegment(const MarkerMotion& motion,
                                                     double leg_length_m);

}  // namespace motiondb::core
