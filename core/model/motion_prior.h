// How markers move on, by a linear rule fitted to all stored motion: what prediction falls back to
// where no stored motion is like the one observed. Ridge regression. Immutable; safe to share.
#pragma once

#include <vector>

#include "core/model/pose_history.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

struct ModelParts;

struct MotionPrior {
  std::vector<double> seconds;  // horizons, ascending; empty where stored clips are too short
  // (1 + kLags) 3 N_v features x (horizons 3 N_v), float.
  FrameMatrix weights;

  // Displacements (3 N_v, leg lengths) from now to `at_seconds` later; between horizons and from
  // now to the first they are interpolated, beyond the last they stay. Zero where there is no rule.
  Eigen::RowVectorXf Displacement(const Eigen::RowVectorXf& features, double at_seconds) const;
};

// What the rule is fitted to: at most some thousands of moments, spread evenly over the clips, each
// also seen in a mirror where the markers have sides.
class MotionSums {
 public:
  // The same bytes for any number of threads. O(moments features^2).
  static MotionSums Over(const ModelParts& parts, const ParallelFor& parallel);

  // Moments in parts that can be left out, to try the rule on what it was not fitted to.
  static constexpr int kParts = 4;
  // The part that holds most moments of a clip.
  int part_of_clip(int clip) const { return part_of_clip_[clip]; }

  MotionPrior Fit(int without_part = -1) const;

 private:
  struct Sums {
    Eigen::MatrixXf features;  // X^T X, lower triangle
    Eigen::MatrixXf products;  // X^T Y
  };
  std::vector<Sums> parts_;  // empty where stored clips are too short
  std::vector<int> part_of_clip_;
  std::size_t moments_ = 0;
};

}  // namespace motiondb::core
