#include "core/recognition/noise_energy.h"

#include <algorithm>

namespace motiondb::core {

double NoiseEnergy(const Eigen::Ref<const FrameMatrix>& window) {
  const Eigen::Index frames = window.rows();
  if (frames < 4) return 0;
  FrameMatrix differences = window.bottomRows(frames - 1) - window.topRows(frames - 1);
  const auto differentiate = [&differences] {
    const Eigen::Index rows = differences.rows() - 1;
    differences = (differences.bottomRows(rows) - differences.topRows(rows)).eval();
    return static_cast<double>(differences.squaredNorm()) / static_cast<double>(rows);
  };
  const double second = differentiate();
  const double third = differentiate();
  return std::max(0.0, 3.0 / 8 * second - 1.0 / 16 * third);
}

}  // namespace motiondb::core
