// The metric for an observation that never shows some markers. Pure; safe to call from any thread.
#pragma once

#include <vector>

#include "core/model/motion_metric.h"

namespace motiondb::core {

// As if the stored motion had no more than the dimensions `seen` (ascending, at least one): with S
// and T the covariances within behaviours and of all motion (motion_metric.h), whitening G is that
// of the block of S, G G^T = S_seen^-1, and the projection takes the whitened directions in which
// the block of T varies most, as far as the loadings tell it. Both have a row for each dimension of
// a state, zero where it is not seen, so that what was filled in there does not count. What was
// learned about the rest stays. O(D^3).
MotionMetric MetricOfSeen(const MotionMetric& metric, const std::vector<Eigen::Index>& seen);

}  // namespace motiondb::core
