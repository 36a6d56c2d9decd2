#include "tests/eval/peers/simple_motion.h"

namespace motiondb::tests {

absl::StatusOr<Forecast> SimpleMotion::Predict(const core::MarkerMotion& past,
                                               const std::vector<double>& horizons) const {
  const Eigen::Index now = past.positions_m.rows() - 1;
  const Eigen::RowVectorXf step = past.positions_m.row(now) - past.positions_m.row(now - 1);
  Forecast forecast;
  forecast.positions_m.resize(static_cast<Eigen::Index>(horizons.size()), past.positions_m.cols());
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const auto frames = static_cast<float>(horizons[h] * past.frame_rate_hz);
    forecast.positions_m.row(static_cast<Eigen::Index>(h)) =
        past.positions_m.row(now) + share_of_velocity_ * frames * step;
  }
  return forecast;
}

}  // namespace motiondb::tests
