// A local Gaussian process over a few stored examples: what each of them counts for what is
// observed. Pure; safe to call from any thread.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"

namespace motiondb::core {

struct ExemplarWeights {
  Eigen::VectorXd weights;  // examples; signed, and they need not sum to 1
  double variance = 1;      // of the process at the query: 0 where the examples tell all, 1 nothing
};

// Kriging with the kernel exp(-distance / kernel_length) and `noise` beside a variance of 1: keys
// of the examples (examples x dimensions), key of the query, distances Euclidean. O(examples^2
// (dimensions + examples)).
ExemplarWeights WeighExemplars(const FrameMatrix& keys, const Eigen::RowVectorXf& query,
                               double kernel_length, double noise);

}  // namespace motiondb::core
