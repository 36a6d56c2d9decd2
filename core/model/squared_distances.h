// Distances of many states to many, by one matrix product. Pure; safe to call from any thread.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"

namespace motiondb::core {

// Squared Euclidean distances, rows of `a` x rows of `b`, whose squared norms are given. Rounding
// is that of the norms: a distance far below them is only known to be small.
inline FrameMatrix SquaredDistances(const Eigen::Ref<const FrameMatrix>& a,
                                    const Eigen::Ref<const FrameMatrix>& b,
                                    const Eigen::Ref<const Eigen::VectorXf>& b_squared_norms) {
  FrameMatrix squared = -2 * a * b.transpose();
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b_squared_norms.transpose();
  return squared.cwiseMax(0);
}

}  // namespace motiondb::core
