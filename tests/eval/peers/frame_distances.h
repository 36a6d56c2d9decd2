// Distances between the frames of two motions. Missing numbers are ignored.
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"

namespace motiondb::tests {

// A stored motion without NaN, prepared for many distances.
struct StoredFrames {
  StoredFrames() = default;
  explicit StoredFrames(core::FrameMatrix stored)
      : frames(std::move(stored)), squares(frames.cwiseAbs2()) {}

  core::FrameMatrix frames;   // frames x dimensions
  core::FrameMatrix squares;  // of each element
};

struct FrameDistances {
  core::FrameMatrix squares;  // observed x stored frames: sum of squared differences
  Eigen::VectorXf present;    // number of values that are not NaN, per observed frame
};

// Exact up to rounding: |a - b|^2 = |a|^2 - 2 a b + |b|^2 over the values present, by matrix
// products.
FrameDistances DistancesTo(const StoredFrames& stored, const core::FrameMatrix& observed);

}  // namespace motiondb::tests
