#include "core/observe/metric_window.h"

#include "core/model/model.h"
#include "core/recognition/unseen_dimensions.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {

MetricWindow::MetricWindow(const Model& model, int window_frames)
    : model_(model),
      finder_(model.clip_index(), static_cast<int>(model.clips().size())),
      frames_(window_frames) {}

void MetricWindow::Restart() {
  for (MetricFrame& frame : frames_) frame.version = -1;
}

void MetricWindow::Make(const ObservedStates& states, std::int64_t frame, MetricFrame& made) {
  const MotionMetric& metric = model_.metric();
  made.state = states.state(frame);
  model_.scale().Apply(made.state);
  if (made.state.hasNaN()) FillUnseen(metric, made.state.row(0));
  difference_ = made.state.row(0) - metric.mean;
  made.projected.resize(metric.projection.cols());
  MultiplyRows(difference_.data(), 1, static_cast<int>(difference_.size()),
               metric.projection.data(), static_cast<int>(made.projected.size()),
               made.projected.data());
  made.squared_norm = made.projected.squaredNorm();
  made.nearest = -1;
  if (ListsAll(static_cast<int>(model_.clips().size()))) return;
  const ClipIndex& index = model_.clip_index();
  distances_.noalias() = made.projected.transpose() * index.means().transpose();
  distances_ =
      (made.squared_norm - 2 * distances_.array() + index.squared_norms().transpose().array())
          .max(0.0F);
  finder_.Find(distances_, made.near);
}

const MetricFrame& MetricWindow::At(const ObservedStates& states, std::int64_t frame) {
  MetricFrame& kept = frames_[Place(frame)];
  const std::int64_t version = 2 * frame + (frame + 1 < states.next() ? 1 : 0);
  if (kept.version != version) {
    Make(states, frame, kept);
    kept.version = version;
  }
  return kept;
}

double MetricWindow::SquaredDifference(std::int64_t frame, int stored_frame) {
  MetricFrame& kept = frames_[Place(frame)];
  if (kept.nearest != stored_frame) {
    const auto dimensions = static_cast<int>(kept.state.cols());
    difference_ = kept.state.row(0) - model_.states().row(stored_frame);
    whitened_.resize(dimensions);
    MultiplyRows(difference_.data(), 1, dimensions, model_.metric().whitening.data(), dimensions,
                 whitened_.data());
    kept.squared_difference = whitened_.squaredNorm();
    kept.nearest = stored_frame;
  }
  return kept.squared_difference;
}

}  // namespace motiondb::core
