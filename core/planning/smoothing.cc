#include "core/planning/smoothing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace motiondb::core {

Eigen::Index FramesOf(double seconds, double frame_rate_hz) {
  return std::max<Eigen::Index>(1, std::lround(seconds * frame_rate_hz));
}

Eigen::ArrayXXd Smooth(const Eigen::ArrayXXd& rows, Eigen::Index reach) {
  Eigen::ArrayXd weights(2 * reach + 1);
  for (Eigen::Index d = -reach; d <= reach; ++d) {
    const double angle = std::numbers::pi * static_cast<double>(d) / static_cast<double>(reach + 1);
    weights[d + reach] = 1 + std::cos(angle);
  }
  weights /= weights.sum();
  Eigen::ArrayXXd smooth = Eigen::ArrayXXd::Zero(rows.rows(), rows.cols());
  for (Eigen::Index t = 0; t < rows.rows(); ++t) {
    for (Eigen::Index d = -reach; d <= reach; ++d) {
      const Eigen::Index from = std::clamp<Eigen::Index>(t + d, 0, rows.rows() - 1);
      smooth.row(t) += weights[d + reach] * rows.row(from);
    }
  }
  return smooth;
}

Eigen::ArrayXd Cover(const Eigen::ArrayXd& values, Eigen::Index reach) {
  Eigen::ArrayXd highest(values.size());
  for (Eigen::Index t = 0; t < values.size(); ++t) {
    const Eigen::Index first = std::max<Eigen::Index>(0, t - reach);
    const Eigen::Index last = std::min(values.size() - 1, t + reach);
    highest[t] = values.segment(first, last - first + 1).maxCoeff();
  }
  return Smooth(highest, reach);
}

}  // namespace motiondb::core
