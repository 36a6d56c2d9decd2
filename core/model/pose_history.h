// Pose history: the current pose and the poses every 0.04 s before, in the current reference frame,
// in leg lengths. Prediction compares moments by this history.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/track.h"

namespace motiondb::core {

inline constexpr double kLagSeconds = 0.04;
inline constexpr int kLags = 9;

// Returns the history, (1 + kLags) x 3 N_v, the current pose first.
FrameMatrix HistoryAt(const Track& track, int frame);

// Returns the input of the motion prior, (1 + kLags) 3 N_v numbers: the pose with a small weight,
// and the movements from lag to lag, the latest with the largest weight.
Eigen::RowVectorXf MotionFeatures(const FrameMatrix& history);

// Returns the key of a moment, 12 N_v numbers: the pose, and the movements over the last 1, 3 and 8
// lags, divided by the square root of the number of markers. The distance of two keys is the
// distance of a typical marker.
Eigen::RowVectorXf HistoryKey(const FrameMatrix& history);
// As above, from the four necessary poses only.
Eigen::RowVectorXf HistoryKeyAt(const Track& track, int frame);

}  // namespace motiondb::core
