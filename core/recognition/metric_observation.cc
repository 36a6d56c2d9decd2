#include "core/recognition/metric_observation.h"

#include <utility>

#include "core/recognition/seen_metric.h"
#include "core/recognition/unseen_dimensions.h"

namespace motiondb::core {

absl::StatusOr<MetricObservation> MetricObservation::Create(const Model& model, FrameMatrix scaled,
                                                            const Cancelled& cancelled) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index d = 0; d < scaled.cols(); ++d) {
    if (!scaled.col(d).array().isNaN().all()) seen.push_back(d);
  }
  std::shared_ptr<const MotionMetric> own;
  if (!seen.empty() && std::ssize(seen) < scaled.cols()) {
    own = std::make_shared<const MotionMetric>(MetricOfSeen(model.metric(), seen));
  }
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    if (!scaled.row(t).hasNaN()) continue;
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    FillUnseen(model.metric(), scaled.row(t));
  }
  FrameMatrix projected = Project(own == nullptr ? model.metric() : *own, scaled);
  return MetricObservation{std::move(scaled), std::move(projected), std::move(own)};
}

std::vector<int> ComparedFrames(int first, int width, int stride, bool from_start) {
  const int newest = first + width - 1;
  std::vector<int> frames;
  for (int f = from_start ? first : first + (width - 1) % stride; f + stride <= newest;
       f += stride) {
    frames.push_back(f);
  }
  frames.push_back(newest);
  return frames;
}

}  // namespace motiondb::core
