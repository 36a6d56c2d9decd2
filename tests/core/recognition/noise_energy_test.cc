#include "core/recognition/noise_energy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace motiondb::tests::noise_energy_test {
namespace {

constexpr double kRate_hz = 60;
constexpr int kDimensions = 12;

// Positions and velocities (central differences) of limbs that swing, with noise of the positions.
// The scales are those of a metric.
core::FrameMatrix Swinging(int frames, double noise, double position_scale, double velocity_scale) {
  std::mt19937 random(7);
  std::normal_distribution<double> draw(0, noise);
  Eigen::MatrixXd positions(frames + 2, kDimensions);
  for (Eigen::Index t = 0; t < positions.rows(); ++t) {
    for (Eigen::Index d = 0; d < kDimensions; ++d) {
      const auto phase = static_cast<double>(d);
      positions(t, d) =
          0.3 * std::sin(2 * static_cast<double>(t) / kRate_hz * (3 + phase / 4) + phase);
      if (noise > 0) positions(t, d) += draw(random);
    }
  }
  core::FrameMatrix states(frames, 2 * kDimensions);
  states.leftCols(kDimensions) = (position_scale * positions.middleRows(1, frames)).cast<float>();
  states.rightCols(kDimensions) =
      (velocity_scale * kRate_hz / 2 * (positions.bottomRows(frames) - positions.topRows(frames)))
          .cast<float>();
  return states;
}

TEST_CASE("NoiseEnergy: the squared distance that noise adds", "[core][recognition]") {
  for (const auto& [position_scale, velocity_scale] :
       {std::pair(4.0, 1.0), std::pair(100.0, 1.0), std::pair(1.0, 0.0), std::pair(0.0, 1.0)}) {
    CAPTURE(position_scale, velocity_scale);
    const core::FrameMatrix clean = Swinging(4000, 0, position_scale, velocity_scale);
    const core::FrameMatrix noisy = Swinging(4000, 0.02, position_scale, velocity_scale);
    const double added = (noisy - clean).rowwise().squaredNorm().mean();
    CHECK(core::NoiseEnergy(noisy) == Approx(added).epsilon(0.05));
    CHECK(core::NoiseEnergy(clean) < 0.002 * clean.rowwise().squaredNorm().mean());
  }
}

TEST_CASE("NoiseEnergy: windows of 0.4 s agree on the average", "[core][recognition]") {
  const core::FrameMatrix noisy = Swinging(2400, 0.02, 4, 1);
  double sum = 0;
  for (int first = 0; first < 2400; first += 24) {
    sum += core::NoiseEnergy(noisy.middleRows(first, 24));
  }
  CHECK(sum / 100 == Approx(core::NoiseEnergy(noisy)).epsilon(0.03));
}

TEST_CASE("NoiseEnergy: none in few frames, constant frames or a straight line",
          "[core][recognition]") {
  CHECK(core::NoiseEnergy(core::FrameMatrix::Random(3, 5)) == 0);
  CHECK(core::NoiseEnergy(core::FrameMatrix(0, 5)) == 0);
  core::FrameMatrix line(10, 1);
  for (int t = 0; t < 10; ++t) line(t, 0) = static_cast<float>(3 * t);
  CHECK(core::NoiseEnergy(line) == 0);
}

}  // namespace
}  // namespace motiondb::tests::noise_energy_test
