// The distribution of states in each node: a Gaussian with diagonal covariance, shrunk towards the
// whole database's, for a node may have 16 frames and the state 204 dimensions. Immutable; safe to
// share. The one place that knows what P_o(x | k) is.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/tree.h"

namespace motiondb::core {

class NodeGaussians {
 public:
  NodeGaussians() = default;

  // From stored means and variances, branches x dimensions. DATA_LOSS if a variance is not
  // positive.
  static absl::StatusOr<NodeGaussians> Create(FrameMatrix means, FrameMatrix variances);

  // From the tree and the scaled states it was built on. Variance of dimension d in node k with n_k
  // frames: (1 - l) var_k + l * 0.3 * var_all, l = 16 / (n_k + 16), at least 1e-3 of the mean of
  // var_all. Leaves are read once, and the other nodes put together from their children:
  // O(frames * dimensions + branches * dimensions), with 16 bytes a branch and dimension beside.
  static NodeGaussians Fit(const Tree& tree, const Eigen::Ref<const FrameMatrix>& states,
                           const ParallelFor& parallel);

  // Those of the tree with more frames (core/tree/tree_builder.h): `tree` and `states` (scaled)
  // hold the frames that these are of, then, from `first_added` on, others. Leaves with added
  // frames are read anew; of the other branches the moments that these statistics tell are put
  // together with those of the added frames, so they follow Fit to single precision, and where a
  // variance stood at its least, to that least. O(added * depth * dimensions + branches *
  // dimensions).
  NodeGaussians Grown(const Tree& tree, int first_added,
                      const Eigen::Ref<const FrameMatrix>& states,
                      const ParallelFor& parallel) const;

  int branch_count() const { return static_cast<int>(means_.rows()); }
  int dimension_count() const { return static_cast<int>(means_.cols()); }
  const FrameMatrix& means() const { return means_; }
  const FrameMatrix& variances() const { return variances_; }

  // log P_o(x | branch), natural, of a scaled state x (dimensions). Missing dimensions (NaN) are
  // left out: the density is that of the others. O(dimensions).
  double LogDensity(int branch, const float* x) const;

  // Whether log P_o(x | branch) is below `log_density` for every x with least <= x <= most
  // (dimensions each, no NaN). May be false though it is.
  bool IsBoxBelow(int branch, const float* least, const float* most, float log_density) const;

  // The same as LogDensity, in single precision, of blocks of frames (ScaledSquaresWithin) without
  // NaN, where it is at least `at_least` (blocks x kSquaresLanes, one a frame); elsewhere it may be
  // minus infinity. Returns false if all are. `scratch` is used again.
  bool LogDensitiesFrom(int branch, const float* frames, int blocks, const float* at_least,
                        std::vector<float>& scratch, float* log_densities) const;

 private:
  FrameMatrix means_;
  FrameMatrix variances_;
  FrameMatrix inverse_deviations_;
  Eigen::VectorXd log_normalizers_;
};

}  // namespace motiondb::core
