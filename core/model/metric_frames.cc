#include "core/model/metric_frames.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/model/model.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {

namespace {

constexpr int kBlockRows = 256;  // gathered states stay in the processor cache

// Projects `rows` of the states into the first rows of `projected`.
void ProjectRows(const MotionMetric& metric, const SharedRows& states, std::span<const int> rows,
                 FrameMatrix& projected, const ParallelFor& parallel) {
  const auto count = static_cast<int>(rows.size());
  parallel((count + kBlockRows - 1) / kBlockRows, [&](int block) {
    const int first = block * kBlockRows;
    FrameMatrix gathered(std::min(kBlockRows, count - first), states.cols());
    for (Eigen::Index r = 0; r < gathered.rows(); ++r) {
      gathered.row(r) = states.row(rows[first + r]) - metric.mean;
    }
    projected.middleRows(first, gathered.rows()) = RowProduct(gathered, metric.projection);
  });
}

}  // namespace

FrameMatrix Project(const MotionMetric& metric, const Eigen::Ref<const FrameMatrix>& states) {
  return RowProduct(states.rowwise() - metric.mean, metric.projection);
}

MetricFrames ProjectStored(const ModelParts& parts, const MetricFrames& known,
                           const ParallelFor& parallel) {
  MetricFrames frames;
  if (parts.metric.empty()) return frames;
  frames.rows = StrideFrames(parts.clips, parts.settings.frame_rate_hz);
  const auto added = std::span(frames.rows.frame).subspan(known.projected.rows());
  const bool is_first = known.projected.rows() == 0;
  const Eigen::Index room = is_first ? RoomToGrow(std::ssize(added)) : 0;
  FrameMatrix projected(std::ssize(added) + room, parts.metric.projection.cols());
  ProjectRows(parts.metric, parts.states, added, projected, parallel);
  const Eigen::VectorXf added_norms = projected.topRows(std::ssize(added)).rowwise().squaredNorm();
  frames.projected = is_first ? SharedRows(std::move(projected), room)
                              : known.projected.WithMore(std::move(projected));
  frames.squared_norms.resize(frames.projected.rows());
  frames.squared_norms << known.squared_norms, added_norms;
  return frames;
}

int FrameStride(double frame_rate_hz) {
  return std::max(1, static_cast<int>(std::lround(frame_rate_hz / 30)));
}

StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz) {
  const int stride = FrameStride(frame_rate_hz);
  StridedFrames strided;
  for (const ModelClip& clip : clips) {
    strided.begin.push_back(static_cast<int>(strided.frame.size()));
    for (int f = 0; f < clip.frame_count; f += stride) {
      strided.frame.push_back(clip.first_frame + f);
    }
  }
  strided.begin.push_back(static_cast<int>(strided.frame.size()));
  return strided;
}

}  // namespace motiondb::core
