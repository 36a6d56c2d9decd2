// How markers move on, by a linear rule fitted to all stored motion: what prediction falls back to
// where no stored motion is like the one observed. Ridge regression. Immutable; safe to share.
#pragma once

#include <Eigen/Core>
#include <utility>
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

// Poses in an orthonormal basis of parts that a mirror leaves as they are (even) and of parts whose
// sign it changes (odd). Sums over motion and its mirror image have no products between even and
// odd parts, so that they and the rule fall into two halves.
class MirrorBasis {
 public:
  // `other_sides` as OtherSides; where it is empty there is no mirror and all is even.
  MirrorBasis(const std::vector<int>& other_sides, int marker_count);

  enum Half { kEven, kOdd };
  int size(Half half) const { return static_cast<int>(terms_[half].size()); }  // of a pose
  // Writes the half of poses (3 N_v numbers each, end to end) to `parts`, as many times size(half).
  void Take(Half half, const Eigen::Ref<const Eigen::RowVectorXf>& poses,
            Eigen::Ref<Eigen::RowVectorXf> parts) const;
  // Adds to `weights`, from poses to poses, the rule from parts to parts.
  void AddRule(Half half, const FrameMatrix& rule, FrameMatrix& weights) const;

 private:
  // a x[first] + b x[second], of the numbers x of a pose.
  struct Term {
    Eigen::Index first, second;
    float a, b;
  };
  std::vector<Term> terms_[2];
  Eigen::Index numbers_ = 0;  // of a pose
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
  explicit MotionSums(MirrorBasis basis) : basis_(std::move(basis)) {}
  // Of one half.
  struct Sums {
    Eigen::MatrixXf features;  // X^T X, lower triangle
    Eigen::MatrixXf products;  // X^T Y
  };
  struct Part {
    Sums halves[2];
  };
  Sums Total(MirrorBasis::Half half, int without_part) const;

  MirrorBasis basis_;
  std::vector<Part> parts_;  // empty where stored clips are too short
  std::vector<int> part_of_clip_;
  std::size_t moments_ = 0;
};

}  // namespace motiondb::core
