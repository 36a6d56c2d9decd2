// Smooth curves over the frames of a motion. Safe to call from any thread.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

// A time as a number of frames, at least one.
Eigen::Index FramesOf(double seconds, double frame_rate_hz);

// Each row's mean with `reach` rows to either side of it, near ones weighing most (a raised
// cosine); the first and the last row stand for those beyond the ends. O(rows * reach).
Eigen::ArrayXXd Smooth(const Eigen::ArrayXXd& rows, Eigen::Index reach);

// A smooth curve that is nowhere below the values: the highest of `reach` to either side, smoothed
// over as many.
Eigen::ArrayXd Cover(const Eigen::ArrayXd& values, Eigen::Index reach);

}  // namespace motiondb::core
