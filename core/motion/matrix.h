// The matrix types that motion travels in. One frame is one row, so a clip can be appended to, cut
// and streamed without touching its other frames.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

// frames x dimensions, row-major, single precision: states and marker positions.
using FrameMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// frames x degrees of freedom, row-major, double precision: joint angles (rad) and translations
// (m).
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace motiondb::core
