// Index from nodes to the clips with frames in them, to find clips similar to an observation
// without comparing all clips. Derived from a model; immutable.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/node_gaussians.h"

namespace motiondb::core {

struct ModelParts;
struct MotionMetric;

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
