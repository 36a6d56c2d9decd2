// Which differences between states matter: those that are small between clips of one behaviour and
// large between all others count most. Learned from the stored clips. Immutable; safe to share.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

struct ModelParts;

// Dimensions D are those of a scaled state.
struct MotionMetric {
  Eigen::RowVectorXf mean;  // D: of the stored frames
  // D x q: how dimensions vary together, x = mean + loadings * h + noise with h standard normal
  // (probabilistic PCA). What is missing follows from what was seen.
  FrameMatrix loadings;
  double noise = 0;  // variance
  // D x D: a difference times it has equal variances within behaviours.
  FrameMatrix whitening;
  // D x K, the 40 whitened directions in which the stored motion varies most: alignment is in them.
  FrameMatrix projection;

  // Models stored before there was a metric have none.
  bool empty() const { return mean.size() == 0; }
};

// Fitted to every stride-th frame (core/model/metric_frames.h), at most 65,536 of them, spread
// evenly. W is the mean of d d^T / 2 over the differences d of paired frames of clips of one label;
// from 65,536 on every second pair, then fewer clips, are taken. Where no label has two clips, of
// frames that follow each other. Clips are brought together in the 48 directions in which all
// motion varies most. With T, the covariance of all frames, and S = 0.8 W + 0.2 (tr W / D) I = V
// diag(w) V^T: whitening = V diag(w)^-1/2, projection = whitening U, U the first eigenvectors of
// whitening^T T whitening. The same bytes for any number of threads.
MotionMetric FitMotionMetric(const ModelParts& parts, const ParallelFor& parallel);

}  // namespace motiondb::core
