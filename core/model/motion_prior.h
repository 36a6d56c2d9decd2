// The motion prior: a linear prediction of marker displacements, fitted to all stored motion by
// ridge regression. Prediction uses it as prior mean. Immutable.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/model/pose_history.h"
#include "core/motion/execution.h"

namespace motiondb::core {

struct ModelParts;

struct MotionPrior {
  std::vector<double> seconds;  // horizons, ascending; empty if stored clips are too short
  // (1 + kLags) 3 N_v features x (horizons 3 N_v)
  FrameMatrix weights;

  // Returns the displacements (3 N_v, leg lengths) from now to `at_seconds` later: interpolated
  // between horizons, constant after the last; zero if the prior is empty.
  Eigen::RowVectorXf Displacement(const Eigen::RowVectorXf& features, double at_seconds) const;
};

// Orthonormal basis of poses: coordinates that mirroring preserves (even) and coordinates whose
// sign it changes (odd). In sums over motion and its mirror image, products of even and odd
// coordinates cancel, so the regression consists of two independent halves.
class MirrorBasis {
 public:
  // `other_sides` as OtherSides; if empty, there is no mirroring and all coordinates are even.
  MirrorBasis(const std::vector<int>& other_sides, int marker_count);

  enum Half { kEven, kOdd };
  int size(Half half) const { return static_cast<int>(terms_[half].size()); }  // of a pose
  // Writes one half of the coordinates of poses (3 N_v numbers each, concatenated) to `parts`
  // (size(half) numbers each).
  void Take(Half half, const Eigen::Ref<const Eigen::RowVectorXf>& poses,
            Eigen::Ref<Eigen::RowVectorXf> parts) const;
  // Adds a linear map between coordinates of one half to `weights`, a map between poses.
  void AddRule(Half half, const FrameMatrix& rule, FrameMatrix& weights) const;

 private:
  // Coordinate a x[first] + b x[second] of a pose x.
  struct Term {
    Eigen::Index first, second;
    float a, b;
  };
  std::vector<Term> terms_[2];
  Eigen::Index numbers_ = 0;  // of a pose
};

// The sums of the regression: over at most 2,500 moments, evenly spread over the clips, and their
// mirror images if the markers have sides.
class MotionSums {
 public:
  // The result does not depend on the number of threads. O(moments features^2).
  static MotionSums Over(const ModelParts& parts, const ParallelFor& parallel);

  // Parts into which the moments are split. Calibration fits without one part and tests on it.
  static constexpr int kParts = 4;
  // Returns the part of the middle moment of a clip.
  int part_of_clip(int clip) const { return part_of_clip_[clip]; }

  MotionPrior Fit(int without_part = -1) const;

 private:
  explicit MotionSums(MirrorBasis basis) : basis_(std::move(basis)) {}
  // Sums of one half.
  struct Sums {
    Eigen::MatrixXf features;  // X^T X, lower triangle
    Eigen::MatrixXf products;  // X^T Y
  };
  struct Part {
    Sums halves[2];
  };
  Sums Total(MirrorBasis::Half half, int without_part) const;

  MirrorBasis basis_;
  std::vector<Part> parts_;  // empty if stored clips are too short
  std::vector<int> part_of_clip_;
  std::size_t moments_ = 0;
};

}  // namespace motiondb::core
