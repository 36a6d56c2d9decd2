// Stored frames for recognition: every stride-th frame of each clip (about 30 Hz), in the metric.
// Derived from a model's states; immutable.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/shared_rows.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

struct ModelClip;
struct ModelParts;
struct MotionMetric;

// Returns the stride for about 30 Hz: 2 at 60 Hz, 1 below 45 Hz.
int FrameStride(double frame_rate_hz);

// Rows [first, first + count) of strided frames.
struct RowRange {
  int first = 0;
  int count = 0;
};

// Every stride-th frame of each clip, beginning with its first.
struct StridedFrames {
  std::vector<int> frame;  // row -> frame of the model
  std::vector<int> begin;  // clip c has the rows begin[c] to begin[c + 1] - 1

  int count(int clip) const { return begin[clip + 1] - begin[clip]; }
  RowRange of_clip(int clip) const { return {begin[clip], count(clip)}; }
};
StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz);

struct MetricFrames {
  StridedFrames rows;
  SharedRows projected;           // rows x K, relative to the metric's mean
  Eigen::VectorXf squared_norms;  // of the projected rows
};

// Returns scaled states (frames x D, without NaN) in the metric: frames x K.
FrameMatrix Project(const MotionMetric& metric, const Eigen::Ref<const FrameMatrix>& states);

// Returns the stored frames in the metric; empty if the model has no metric. `known`: frames of the
// base of an extension, whose memory the result shares; otherwise empty. Only the result needs
// memory proportional to the frames.
MetricFrames ProjectStored(const ModelParts& parts, const MetricFrames& known,
                           const ParallelFor& parallel);

}  // namespace motiondb::core
