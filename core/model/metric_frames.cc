#include "core/model/metric_frames.h"

#include "core/model/model.h"

namespace motiondb::core {

FrameMatrix Project(const MotionMetric& metric, const FrameMatrix& states) {
  return (states.rowwise() - metric.mean) * metric.projection;
}

MetricFrames ProjectStored(const ModelParts& parts) {
  MetricFrames frames;
  if (parts.metric.empty()) return frames;
  frames.rows = StrideFrames(parts.clips, parts.settings.frame_rate_hz);
  frames.projected = Project(parts.metric, parts.states(frames.rows.frame, Eigen::all));
  frames.squared_norms = frames.projected.rowwise().squaredNorm();
  return frames;
}

}  // namespace motiondb::core
