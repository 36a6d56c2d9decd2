// What state vectors are divided by before the tree is built: metres and metres per second are not
// comparable as they stand. Belongs to the model. Plain value.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

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

// The variance of each dimension (1 x dimensions) about its own mean, but for numbers that are
// further from the middle 98 % of their dimension than twice its width (or, where that is narrow,
// than twice the mean width of its kind): a few corrupt frames do not change it. REQUIRES: finite
// states. The same bytes for any number of threads.
Eigen::RowVectorXd RobustVariances(const Eigen::Ref<const FrameMatrix>& states,
                                   const ParallelFor& parallel = RunSerially);

// The scale for these states (frames x dimensions, six numbers a marker: position, velocity). The
// pooled standard deviation is the root of the mean of the dimensions' variances, each about its
// own mean (RobustVariances). A dimension or kind that never varies is divided by 1.
FeatureScale MakeFeatureScale(Scaling scaling, const Eigen::Ref<const FrameMatrix>& states,
                              const ParallelFor& parallel = RunSerially);

}  // namespace motiondb::core
