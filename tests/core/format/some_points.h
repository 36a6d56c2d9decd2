// Motion of points with gaps, for the tests of writers.
#pragma once

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::tests {

// Points within a few metres of `centre_m`, of which a fifth is missing.
inline core::MarkerMotion PointsWithGaps(std::vector<std::string> names, int frames,
                                         float centre_m = 0) {
  core::MarkerMotion motion = {.names = std::move(names), .frame_rate_hz = 50, .positions_m = {}};
  const auto points = static_cast<Eigen::Index>(motion.names.size());
  motion.positions_m.resize(frames, 3 * points);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> coordinate(centre_m - 3, centre_m + 3);
  for (int t = 0; t < frames; ++t) {
    for (Eigen::Index p = 0; p < points; ++p) {
      const bool missing = random() % 5 == 0;
      for (Eigen::Index c = 3 * p; c < 3 * p + 3; ++c) {
        motion.positions_m(t, c) =
            missing ? std::numeric_limits<float>::quiet_NaN() : coordinate(random);
      }
    }
  }
  return motion;
}

// Largest difference of coordinates (m); infinite if sizes or missing points differ.
inline double MaxDifference(const core::MarkerMotion& a, const core::MarkerMotion& b) {
  const auto& left = a.positions_m;
  const auto& right = b.positions_m;
  if (left.rows() != right.rows() || left.cols() != right.cols() ||
      (left.array().isNaN() != right.array().isNaN()).any()) {
    return std::numeric_limits<double>::infinity();
  }
  const core::FrameMatrix difference = (left - right).array().isNaN().select(0, left - right);
  return difference.cwiseAbs().maxCoeff();
}

}  // namespace motiondb::tests
