// Where a tree's nodes are divided (section III-B): the principal axis of each divided branch and
// the threshold on it, so that states which the tree was not built from can go down it. Immutable
// once made; safe to share.
#pragma once

#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

// One row for each branch that is divided, in order of branch. Empty where they are not known, as
// in trees of older stores.
struct SplitPlanes {
  FrameMatrix axes;  // divided branches x dimensions, of unit length
  // States whose inner product with the axis is at most this go left.
  std::vector<double> thresholds;

  bool empty() const { return thresholds.empty(); }
};

// Whether a state (1 x dimensions) goes left at a threshold on an axis.
inline bool IsLeft(const Eigen::Ref<const Eigen::RowVectorXf>& axis, double threshold,
                   const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  return axis.cast<double>().dot(state.cast<double>()) <= threshold;
}

}  // namespace motiondb::core
