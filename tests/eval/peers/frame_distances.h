// Distances between the frames of two motions, missing numbers left out. Safe to call from any
// thread.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"

namespace motiondb::tests {

// A stored motion, made ready for many distances to it. It has no NaN.
struct StoredFrames {
  StoredFrames() = default;
  explicit StoredFrames(core::FrameMatrix stored)
      : frames(std::move(stored)), squares(frames.cwiseAbs2()) {}

  core::FrameMatrix frames;   // frames x dimensions
  core::FrameMatrix squares;  // of each number
};

struct FrameDistances {
  core::FrameMatrix squares;  // observed x stored frames: sum of squared differences
  Eigen::VectorXf present;    // how many numbers of each observed frame are not NaN
};

// Exact up to rounding: |a - b|^2 = |a|^2 - 2 a b + |b|^2 over the numbers present, by matrix
// products.
FrameDistances DistancesTo(const StoredFrames& stored, const core::FrameMatrix& observed);

}  // namespace motiondb::tests
