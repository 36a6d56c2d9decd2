#include "core/model/metric_frames.h"

#include "core/model/model.h"

namespace motiondb::core {

FrameMatrix Project(const MotionMetric& metric, const Eigen::Ref<const FrameMatrix>& states) {
  return (states.rowwise() - metric.mean) * metric.projection;
}

MetricFrames ProjectStored(const ModelParts& parts, const MetricFrames& known) {
  MetricFrames frames;
  if (parts.metric.empty()) return frames;
  frames.rows = StrideFrames(parts.clips, parts.settings.frame_rate_hz);
  const std::vector<int> more(frames.rows.frame.begin() + known.projected.rows(),
                              frames.rows.frame.end());
  const FrameMatrix projected = Project(parts.metric, parts.states.view()(more, Eigen::all));
  frames.projected = known.projected.WithMore(projected);
  frames.squared_norms.resize(frames.projected.rows());
  frames.squared_norms << known.squared_norms, projected.rowwise().squaredNorm();
  return frames;
}

}  // namespace motiondb::core
