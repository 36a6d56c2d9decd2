// The distribution P_o(x | k) of states in each node: a Gaussian with diagonal covariance, shrunk
// towards that of the whole database, because a node may have 16 frames and a state 204 dimensions.
// Immutable.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/tree.h"

namespace motiondb::core {

class NodeGaussians {
 public:
  NodeGaussians() = default;

  // Creates it from stored means and variances (branches x dimensions). DATA_LOSS if a variance is
  // not positive.
  static absl::StatusOr<NodeGaussians> Create(FrameMatrix means, FrameMatrix variances);

  // Computes the statistics of a tree from its scaled states. Variance of a dimension in node k
  // with n_k frames: (1 - l) var_k + l * 0.3 * var_all, l = 16 / (n_k + 16), at least 1e-3 of the
  // mean of var_all. Reads the frames of leaves once and combines the statistics of children for
  // other nodes: O(frames * dimensions + branches * dimensions); temporary memory: 16 bytes for
  // each branch and dimension.
  static NodeGaussians Fit(const Tree& tree, const Eigen::Ref<const FrameMatrix>& states,
                           const ParallelFor& parallel);

  // Returns the statistics of an extended tree (core/tree/tree_builder.h): `tree` and `states`
  // (scaled) have the frames of these statistics, followed by added frames from `first_added` on.
  // Reads all frames of leaves with added frames. For other branches, combines the moments of these
  // statistics with those of the added frames: equal to Fit within single precision, except for
  // variances at their minimum. O(added * depth * dimensions + branches * dimensions).
  NodeGaussians Grown(const Tree& tree, int first_added,
                      const Eigen::Ref<const FrameMatrix>& states,
                      const ParallelFor& parallel) const;

  int branch_count() const { return static_cast<int>(means_.rows()); }
  int dimension_count() const { return static_cast<int>(means_.cols()); }
  const FrameMatrix& means() const { return means_; }
  const FrameMatrix& variances() const { return variances_; }

  // Returns the natural logarithm of P_o(x | branch) for a scaled state x (dimensions). Ignores
  // missing dimensions (NaN). O(dimensions).
  double LogDensity(int branch, const float* x) const;

  // Returns whether log P_o(x | branch) is below `log_density` for every x with low <= x <= high
  // (dimensions each, no NaN). Can be false although it is.
  bool IsBoxBelow(int branch, const float* low, const float* high, float log_density) const;

  // LogDensity in single precision for blocks of frames (ScaledSquaresWithin) without NaN.
  // Densities below `at_least` (blocks x kSquaresLanes, one for each frame) may be minus infinity.
  // Returns false if all are. `scratch` is reused.
  bool LogDensitiesFrom(int branch, const float* frames, int blocks, const float* at_least,
                        std::vector<float>& scratch, float* log_densities) const;

 private:
  FrameMatrix means_;
  FrameMatrix variances_;
  FrameMatrix inverse_deviations_;
  Eigen::VectorXd log_normalizers_;
};

}  // namespace motiondb::core
