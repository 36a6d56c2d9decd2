// Stored clips in the metric of recognition: every stride-th frame of each clip (about 30 Hz), and
// an index from nodes to the clips with frames in them, to find clips similar to an observation
// without comparing all clips. Derived from a model; immutable.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/model/shared_rows.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/node_gaussians.h"

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

// Returns the squared Euclidean distances, rows of `a` x rows of `b`. The rounding error is
// proportional to the squared norms, so distances much smaller than the norms are inexact.
FrameMatrix SquaredDistances(const Eigen::Ref<const FrameMatrix>& a,
                             const Eigen::Ref<const FrameMatrix>& b,
                             const Eigen::Ref<const Eigen::VectorXf>& b_squared_norms);

// Index from nodes to the clips with frames in them.
class ClipIndex {
 public:
  ClipIndex() = default;
  // Returns an empty index if the model has no metric.
  static ClipIndex Of(const ModelParts& parts);

  int node_count() const { return static_cast<int>(means_.rows()); }
  // Means of the indexed nodes in the metric, nodes x K, and their squared norms.
  const FrameMatrix& means() const { return means_; }
  const Eigen::VectorXf& squared_norms() const { return squared_norms_; }
  // Returns the means in another metric, nodes x K. `gaussians`: node statistics of the model.
  FrameMatrix MeansIn(const MotionMetric& metric, const NodeGaussians& gaussians) const;
  // Returns the index of the nodes that contain frames of the clips with `allowed[clip]`. O(index).
  ClipIndex Restricted(const std::vector<bool>& allowed) const;
  // Clips with frames in a node, ascending.
  std::span<const int> clips(int node) const {
    return std::span(clips_).subspan(begin_[node], begin_[node + 1] - begin_[node]);
  }

 private:
  std::vector<int> branches_;  // [node], index into the branches of the tree
  FrameMatrix means_;
  Eigen::VectorXf squared_norms_;
  std::vector<int> begin_;  // node n has clips_[begin_[n]] to clips_[begin_[n + 1] - 1]
  std::vector<int> clips_;
};

}  // namespace motiondb::core
