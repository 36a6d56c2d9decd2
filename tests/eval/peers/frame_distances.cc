#include "tests/eval/peers/frame_distances.h"

#include <cmath>

namespace motiondb::tests {

FrameDistances DistancesTo(const StoredFrames& stored, const core::FrameMatrix& observed) {
  const core::FrameMatrix mask =
      observed.unaryExpr([](float x) { return std::isnan(x) ? 0.0F : 1.0F; });
  const core::FrameMatrix values =
      observed.unaryExpr([](float x) { return std::isnan(x) ? 0.0F : x; });
  FrameDistances distances;
  distances.present = mask.rowwise().sum();
  distances.squares.noalias() = -2.0F * values * stored.frames.transpose();
  const bool whole = distances.present.minCoeff() == static_cast<float>(observed.cols());
  if (whole) {
    distances.squares.rowwise() += stored.squares.rowwise().sum().transpose();
  } else {
    distances.squares.noalias() += mask * stored.squares.transpose();
  }
  distances.squares.colwise() += values.rowwise().squaredNorm();
  distances.squares = distances.squares.cwiseMax(0.0F);
  return distances;
}

}  // namespace motiondb::tests
