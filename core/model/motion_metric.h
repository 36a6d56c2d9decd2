// The metric of recognition, learned from the stored clips: it weights differences that are small
// within a behaviour and large between behaviours. Immutable.
#pragma once

#include <Eigen/Core>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

struct ModelParts;

// D: dimensions of a scaled state.
struct MotionMetric {
  Eigen::RowVectorXf mean;  // D: mean of the stored frames
  // D x q: probabilistic PCA, x = mean + loadings * h + noise with standard normal h. Used to fill
  // in missing dimensions.
  FrameMatrix loadings;
  double noise = 0;  // variance
  // D x D: differences within behaviours, multiplied by this matrix, have equal variances.
  FrameMatrix whitening;
  // D x K: the 40 whitened directions with the largest variance of stored motion; used by
  // alignment.
  FrameMatrix projection;

  // Models stored by old versions have no metric.
  bool empty() const { return mean.size() == 0; }
};

// Fits the metric to every stride-th frame (core/model/metric_frames.h), at most 65,536, evenly
// spread. W is the mean of d d^T / 2 over the differences d between corresponding frames of units
// (label_units.h) of one label of kActionTrack; beyond 65,536 differences, every second pair and
// then fewer units are used. If no label has two units, d are differences between successive
// frames. Units are aligned in the 48 directions with the largest variance. With T the covariance
// of all frames and S = 0.8 W + 0.2 (tr W / D) I = V diag(w) V^T: whitening = V diag(w)^-1/2,
// projection = whitening U with U the first eigenvectors of whitening^T T whitening. The result
// does not depend on the number of threads.
MotionMetric FitMotionMetric(const ModelParts& parts, const ParallelFor& parallel);

}  // namespace motiondb::core
