// From nodes to the clips that pass through them: finds clips like an observation without a look
// at each. Derived from a model; immutable, safe to share.
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
  // Empty where the model has no metric.
  static ClipIndex Of(const ModelParts& parts);

  int node_count() const { return static_cast<int>(means_.rows()); }
  // Means of the indexed nodes in the metric, nodes x K, and their squared norms.
  const FrameMatrix& means() const { return means_; }
  const Eigen::VectorXf& squared_norms() const { return squared_norms_; }
  // The same means in another metric; `gaussians` are the model's.
  FrameMatrix MeansIn(const MotionMetric& metric, const NodeGaussians& gaussians) const;
  // Clips with frames in a node, ascending.
  std::span<const int> clips(int node) const {
    return std::span(clips_).subspan(begin_[node], begin_[node + 1] - begin_[node]);
  }

 private:
  std::vector<int> branches_;  // of the tree, one a node
  FrameMatrix means_;
  Eigen::VectorXf squared_norms_;
  std::vector<int> begin_;  // of each node's clips, and the end
  std::vector<int> clips_;
};

}  // namespace motiondb::core
