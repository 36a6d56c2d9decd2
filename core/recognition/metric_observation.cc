#include "core/recognition/metric_observation.h"

#include <utility>

#include "core/recognition/unseen_dimensions.h"

namespace motiondb::core {

absl::StatusOr<MetricObservation> MetricObservation::Create(const Model& model, FrameMatrix scaled,
                                                            const Cancelled& cancelled) {
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    if (!scaled.row(t).hasNaN()) continue;
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    FillUnseen(model.metric(), scaled.row(t));
  }
  FrameMatrix projected = Project(model.metric(), scaled);
  return MetricObservation{std::move(scaled), std::move(projected)};
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
