#include "core/observe/metric_window.h"

#include <algorithm>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/recognition/alignment_loops.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/window_alignment.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {

MetricWindow::MetricWindow(const Model& model, const ClipMask* mask, int window_frames)
    : model_(model),
      mask_(mask),
      index_(AllowedIndex(model, mask)),
      finder_(index_, static_cast<int>(model.clips().size())),
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
  made.has_near = false;
}

void MetricWindow::FindNear(MetricFrame& made) {
  made.has_near = true;
  made.near.clear();
  if (ListsAll(AllowedCount(model_, mask_))) return;
  distances_.noalias() = made.projected.transpose() * index_.means().transpose();
  distances_ =
      (made.squared_norm - 2 * distances_.array() + index_.squared_norms().transpose().array())
          .max(0.0F);
  finder_.Find(distances_, made.near);
}

const MetricFrame& MetricWindow::Projected(const ObservedStates& states, std::int64_t frame) {
  MetricFrame& kept = frames_[Place(frame)];
  const std::int64_t version = 2 * frame + (frame + 1 < states.next() ? 1 : 0);
  if (kept.version != version) {
    Make(states, frame, kept);
    kept.version = version;
  }
  return kept;
}

const MetricFrame& MetricWindow::At(const ObservedStates& states, std::int64_t frame) {
  Projected(states, frame);
  MetricFrame& kept = frames_[Place(frame)];
  if (!kept.has_near) FindNear(kept);
  return kept;
}

double MetricWindow::SquaredDifference(std::int64_t frame, int stored_frame) {
  MetricFrame& kept = frames_[Place(frame)];
  if (kept.nearest != stored_frame) {
    const auto dimensions = static_cast<int>(kept.state.cols());
    difference_ = kept.state.row(0) - NearestState(model_, stored_frame, kept.state.row(0));
    whitened_.resize(dimensions);
    MultiplyRows(difference_.data(), 1, dimensions, model_.metric().whitening.data(), dimensions,
                 whitened_.data());
    kept.squared_difference = whitened_.squaredNorm();
    kept.nearest = stored_frame;
  }
  return kept.squared_difference;
}

void CachedClip::Take(const Model& model, int clip, int window_frames) {
  clip_ = clip;
  first_row_ = model.metric_frames().rows.begin[clip];
  version_.assign(window_frames, -1);
  nearest_.resize(window_frames);
  const Eigen::Index count = model.metric_frames().rows.count(clip);
  roots_.resize(count, window_frames);
  distances_.resize(count);
}

const NearestFrame& CachedClip::Compare(const Model& model, std::size_t ring,
                                        const MetricFrame& frame) {
  if (version_[ring] == frame.version) return nearest_[ring];
  version_[ring] = frame.version;
  const MetricFrames& stored = model.metric_frames();
  const Eigen::Index first = first_row_;
  const Eigen::Index count = stored.rows.count(clip_);
  SquaredDistancesOfOne(stored.projected.row(first).data(), stored.squared_norms.data() + first,
                        static_cast<int>(count), static_cast<int>(frame.projected.size()),
                        frame.projected.data(), frame.squared_norm, distances_.data());
  const float min_distance = Minimum(distances_.data(), static_cast<int>(count));
  const auto nearest =
      std::find(distances_.begin(), distances_.end(), min_distance) - distances_.begin();
  nearest_[ring] = {min_distance, stored.rows.frame[first + nearest]};
  PathSum::Roots(distances_, min_distance, roots_.col(static_cast<Eigen::Index>(ring)));
  return nearest_[ring];
}

bool CachedClip::LogEvidence(RowRange rows, std::span<const std::size_t> rings, PathSum& paths,
                             double& log_evidence) const {
  paths.Begin(rows.count, false);
  for (const std::size_t ring : rings) {
    paths.AddRoots(
        roots_.col(static_cast<Eigen::Index>(ring)).segment(rows.first - first_row_, rows.count),
        nearest_[ring].squared_distance);
  }
  log_evidence = paths.LogEvidence();
  return paths.IsExact();
}

double CachedClip::LogEvidenceBound(int count, std::span<const std::size_t> rings) const {
  double sum = 0;
  for (const std::size_t ring : rings) sum += nearest_[ring].squared_distance;
  return PathSum::LogEvidenceBound(count, sum);
}

}  // namespace motiondb::core
