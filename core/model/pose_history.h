// The last moments of a motion, as prediction compares them: poses now and every 0.04 s before, in
// the reference frame of now, leg lengths. Pure functions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/track.h"

namespace motiondb::core {

inline constexpr double kLagSeconds = 0.04;
inline constexpr int kLags = 9;

// 1 + kLags rows (now first) x 3 N_v.
FrameMatrix HistoryAt(const Track& track, int frame);

// What the linear prior looks at, (1 + kLags) 3 N_v numbers: the pose, lightly, and how it moved
// from each lag to the next, the latest most.
Eigen::RowVectorXf MotionFeatures(const FrameMatrix& history);

// What the distance between two moments is taken over, 12 N_v numbers: the pose, and how it moved
// over the last one, three and eight lags. Divided by the root of the number of markers, so that a
// distance is that of a typical marker.
Eigen::RowVectorXf HistoryKey(const FrameMatrix& history);
// The same without the whole history: four poses are enough.
Eigen::RowVectorXf HistoryKeyAt(const Track& track, int frame);

}  // namespace motiondb::core
