// An observation as recognition compares it with stored clips, in the metric: what it lacks is
// filled in, what it never shows is left out. Immutable; safe to share.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/motion_metric.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

struct MetricObservation {
  FrameMatrix states;     // frames x D, scaled; what was missing is filled in
  FrameMatrix projected;  // frames x K, in `own` if there is one, else in the model's metric
  // Where the observation never shows some dimensions: the metric of the others.
  std::shared_ptr<const MotionMetric> own;

  // From scaled states with NaN where a marker is missing. CANCELLED.
  static absl::StatusOr<MetricObservation> Create(const Model& model, FrameMatrix scaled,
                                                  const Cancelled& cancelled = {});

  const MotionMetric& MetricFor(const Model& model) const {
    return own == nullptr ? model.metric() : *own;
  }
};

// Which of the frames [first, first + width) are compared: every stride-th, ending with the newest.
// `from_start` takes frames first, first + stride, ... and then the newest: a stored clip is then
// compared from its own start.
std::vector<int> ComparedFrames(int first, int width, int stride, bool from_start);

// As if the stored motion had no more than the dimensions `seen` (ascending, at least one): with S
// and T the covariances within behaviours and of all motion (motion_metric.h), whitening G is that
// of the block of S, G G^T = S_seen^-1, and the projection takes the whitened directions in which
// the block of T varies most, as far as the loadings tell it. Both have a row for each dimension of
// a state, zero where it is not seen, so that what was filled in there does not count. What was
// learned about the rest stays. O(D^3).
MotionMetric MetricOfSeen(const MotionMetric& metric, const std::vector<Eigen::Index>& seen);

// Replaces the NaN of a scaled state (D) by their mean given its other dimensions, under the
// metric's probabilistic PCA: with o what was seen and L the loadings, h = (L_o^T L_o + noise I)^-1
// L_o^T (x_o - mean_o) and x = mean + L h. O(q^2 D).
void FillUnseen(const MotionMetric& metric, Eigen::Ref<Eigen::RowVectorXf> state);

}  // namespace motiondb::core
