#include "core/recognition/metric_observation.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::metric_observation_test {
namespace {

Eigen::MatrixXd WithinBehaviours(const core::MotionMetric& metric) {
  const Eigen::MatrixXd inverse = (metric.whitening * metric.whitening.transpose()).cast<double>();
  return inverse.inverse();
}

}  // namespace

TEST_CASE("MetricOfSeen: equals the metric of the seen dimensions alone", "[core][recognition]") {
  const core::Model model = SmallModel(6, 200, 4, 8, 3);
  const core::MotionMetric& metric = model.metric();
  std::vector<Eigen::Index> seen;
  for (Eigen::Index d = 0; d < metric.mean.size(); ++d) {
    if (d / 6 != 1) seen.push_back(d);  // all of the second marker is missing
  }
  const core::MotionMetric own = core::MetricOfSeen(metric, seen);
  const Eigen::MatrixXd block = WithinBehaviours(metric)(seen, seen);
  const Eigen::MatrixXd whitening = own.whitening(seen, Eigen::all).cast<double>();
  const Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(block.rows(), block.cols());
  CHECK((whitening.transpose() * block * whitening - expected).norm() < 1e-2);
  const Eigen::MatrixXd projection = own.projection(seen, Eigen::all).cast<double>();
  CHECK((projection.transpose() * block * projection -
         Eigen::MatrixXd::Identity(projection.cols(), projection.cols()))
            .norm() < 1e-2);
  for (Eigen::Index d = 6; d < 12; ++d) {
    CHECK(own.whitening.row(d).isZero());
    CHECK(own.projection.row(d).isZero());
  }
  // If all dimensions are seen, distances in the kept directions do not change.
  std::vector<Eigen::Index> all(static_cast<std::size_t>(metric.mean.size()));
  std::iota(all.begin(), all.end(), 0);
  const core::MotionMetric same = core::MetricOfSeen(metric, all);
  const core::FrameMatrix apart = model.states().row(10) - model.states().row(300);
  CHECK((apart * same.whitening).norm() == Approx((apart * metric.whitening).norm()).epsilon(1e-3));
}

TEST_CASE("Recognize: a marker that is never seen has no effect", "[core][recognition]") {
  const core::Model model = SmallModel(6, 240, 5, 8, 31);
  for (int c = 0; c < 6; ++c) {
    core::StateSequence clip = WanderingClips(6, 240, model.marker_set(), 31)[c].states;
    clip.states.middleCols<6>(18).setConstant(std::nanf(""));
    const auto windows = core::Recognize(model, clip, {});
    REQUIRE(windows.ok());
    for (const core::RecognizedWindow& window : *windows) {
      CHECK(window.labels.front().label == (c % 2 == 0 ? "a" : "b"));
    }
  }
}

namespace {

core::MotionMetric SmallMetric() {
  std::mt19937 random(8);
  std::normal_distribution<float> normal;
  core::MotionMetric metric;
  metric.mean.resize(12);
  metric.loadings.resize(12, 4);
  for (float& number : metric.mean) number = normal(random);
  for (Eigen::Index i = 0; i < metric.loadings.size(); ++i) {
    metric.loadings.data()[i] = normal(random);
  }
  metric.noise = 0.05;
  return metric;
}

}  // namespace

TEST_CASE("FillUnseen: equals the conditional mean of the Gaussian", "[core][recognition]") {
  const core::MotionMetric metric = SmallMetric();
  const Eigen::MatrixXd loadings = metric.loadings.cast<double>();
  const Eigen::MatrixXd covariance =
      loadings * loadings.transpose() + metric.noise * Eigen::MatrixXd::Identity(12, 12);
  std::mt19937 random(3);
  for (int missing = 1; missing < 12; ++missing) {
    Eigen::RowVectorXf state = WanderingStates(1, 12, static_cast<unsigned>(missing));
    const Eigen::RowVectorXf whole = state;
    std::vector<int> seen;
    std::vector<int> unseen;
    for (int d = 0; d < 12; ++d) {
      (static_cast<int>((d * 5 + random() % 2) % 12) < missing ? unseen : seen).push_back(d);
    }
    for (const int d : unseen) state[d] = std::nanf("");
    core::FillUnseen(metric, state);
    const Eigen::VectorXd apart = (whole - metric.mean)(seen).transpose().cast<double>();
    const Eigen::MatrixXd of_seen = covariance(seen, seen);
    const Eigen::VectorXd expected = metric.mean(unseen).transpose().cast<double>() +
                                     covariance(unseen, seen) * of_seen.lu().solve(apart);
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      CHECK(state[unseen[i]] ==
            Approx(expected[static_cast<Eigen::Index>(i)]).epsilon(1e-3).margin(1e-3));
    }
    for (const int d : seen) CHECK(state[d] == whole[d]);
  }
}

TEST_CASE("FillUnseen: returns the mean if nothing is seen, the state if nothing is missing",
          "[core][recognition]") {
  const core::MotionMetric metric = SmallMetric();
  Eigen::RowVectorXf none = Eigen::RowVectorXf::Constant(12, std::nanf(""));
  core::FillUnseen(metric, none);
  CHECK(none == metric.mean);
  Eigen::RowVectorXf all = Eigen::RowVectorXf::Ones(12);
  core::FillUnseen(metric, all);
  CHECK(all == Eigen::RowVectorXf::Ones(12));
}

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

}  // namespace motiondb::tests::metric_observation_test
