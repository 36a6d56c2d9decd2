// The stored frames as recognition compares them: every stride-th of each clip, in the metric.
// Derived from a model's states; immutable, safe to share.
#pragma once

#include <Eigen/Core>

#include "core/model/frame_stride.h"
#include "core/model/shared_rows.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

struct ModelParts;
struct MotionMetric;

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
