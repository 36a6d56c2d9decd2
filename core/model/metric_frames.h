// The stored frames as recognition compares them, about 30 a second: every stride-th of each clip,
// in the metric. Derived from a model's states; immutable, safe to share.
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

// Frames from one compared to the next: 2 at 60 Hz, 1 below 45 Hz.
int FrameStride(double frame_rate_hz);

// Every stride-th frame of each clip, from its first.
struct StridedFrames {
  std::vector<int> frame;  // row -> frame of the model
  std::vector<int> begin;  // clip c has the rows [begin[c], begin[c + 1])

  int count(int clip) const { return begin[clip + 1] - begin[clip]; }
};
StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz);

struct MetricFrames {
  StridedFrames rows;
  SharedRows projected;           // rows x K, about the metric's mean
  Eigen::VectorXf squared_norms;  // of the rows
};

// Scaled states (frames x D, without NaN) in the metric: frames x K.
FrameMatrix Project(const MotionMetric& metric, const Eigen::Ref<const FrameMatrix>& states);

// Empty where the model has no metric. `known` are those of the model that this one extends, or
// empty: they are shared. Takes no memory that grows with the frames but the result's.
MetricFrames ProjectStored(const ModelParts& parts, const MetricFrames& known,
                           const ParallelFor& parallel);

}  // namespace motiondb::core
