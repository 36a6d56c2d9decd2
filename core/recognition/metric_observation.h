// An observation in the metric, for comparison with stored clips: gaps are filled in, markers that
// are never seen are excluded, and the noise is estimated.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/motion_metric.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

struct MetricObservation {
  FrameMatrix states;     // frames x D, scaled, missing values filled in
  FrameMatrix projected;  // frames x K, in `own` if it is not null, else in the model's metric
  // Metric of the seen dimensions; null if all dimensions were seen.
  std::shared_ptr<const MotionMetric> own;

  // `scaled`: scaled states with NaN for missing markers. CANCELLED.
  static absl::StatusOr<MetricObservation> Create(const Model& model, FrameMatrix scaled,
                                                  const Cancelled& cancelled = {});

  const MotionMetric& MetricFor(const Model& model) const {
    return own == nullptr ? model.metric() : *own;
  }
};

// Returns the compared frames of [first, first + width): every stride-th frame, ending with the
// newest. If `from_start`: first, first + stride, ..., and the newest, so that a stored clip is
// compared from its start.
std::vector<int> ComparedFrames(int first, int width, int stride, bool from_start);

// Returns the metric of motion that has only the dimensions `seen` (ascending, not empty). With the
// covariances S within behaviours and T of all motion (motion_metric.h): the whitening G satisfies
// G G^T = S_seen^-1, and the projection consists of the whitened directions with the largest
// variance of T_seen, as given by the loadings. Both have a row for each dimension of a state, zero
// for unseen dimensions, so filled-in values have no effect. Mean, loadings and noise are
// unchanged. O(D^3).
MotionMetric MetricOfSeen(const MotionMetric& metric, const std::vector<Eigen::Index>& seen);

// Replaces each NaN of a scaled state (D) by its conditional mean under the metric's probabilistic
// PCA. With the seen dimensions o and the loadings L: h = (L_o^T L_o + noise I)^-1 L_o^T (x_o -
// mean_o), x = mean + L h. O(q^2 D).
void FillUnseen(const MotionMetric& metric, Eigen::Ref<Eigen::RowVectorXf> state);

// Returns the part of a frame's squared distance from any motion that is due to noise of the
// markers, mean over the frames: an estimate from successive frames of a window (frames x K, in the
// metric). Human motion is smooth, so differences between successive frames consist of noise. If
// the marker positions have independent noise in each frame, the positions of the states have white
// noise p, and their velocities, central differences of positions, have noise v. Squares of second
// differences have the mean 6 p + 5 v, those of third differences 20 p + 14 v; the result, 3/8 of
// the former less 1/16 of the latter, has the mean p + v. One-sided velocities, as of the newest
// frame, have more noise, so leave them out. 0 for fewer than 4 frames.
double NoiseEnergy(const Eigen::Ref<const FrameMatrix>& window);

}  // namespace motiondb::core
