// Matrix types of motion. One frame is one row, so clips are appended, cut and streamed by rows.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

// frames x dimensions, row-major, single precision: states and marker positions.
using FrameMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// frames x degrees of freedom, row-major, double precision: joint angles (rad), translations (m).
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace motiondb::core
