// Scale of state vectors: positions and velocities have different units, so they are divided by
// their deviations before the tree is built. Part of the model.
#pragma once

#include <Eigen/Core>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

enum class Scaling {
  kNone,       // nothing, as in the paper
  kKind,       // positions by their pooled standard deviation, velocities by theirs
  kDimension,  // each dimension by its own
};

struct FeatureScale {
  Eigen::RowVectorXf divisor;  // 1 x dimensions, positive

  // Scales states in place: frames x dimensions. NaN stays NaN.
  void Apply(FrameMatrix& states) const;
  // Undoes Apply.
  void Revert(FrameMatrix& states) const;
};

// Returns the variance of each dimension (1 x dimensions) without outliers: numbers whose distance
// from the middle 98 % of their dimension is more than twice its width (or twice the mean width of
// the kind, if that is larger). A few corrupt frames do not change it. REQUIRES: finite states. The
// result does not depend on the number of threads.
Eigen::RowVectorXd RobustVariances(const Eigen::Ref<const FrameMatrix>& states,
                                   const ParallelFor& parallel = RunSerially);

// Returns the scale for states (frames x dimensions; position and velocity of each marker). The
// pooled standard deviation is the square root of the mean of the dimensions' variances
// (RobustVariances). The divisor of a dimension or kind without variance is 1.
FeatureScale MakeFeatureScale(Scaling scaling, const Eigen::Ref<const FrameMatrix>& states,
                              const ParallelFor& parallel = RunSerially);

}  // namespace motiondb::core
