#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "core/recognition/metric_observation.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::unseen_dimensions_test {
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

}  // namespace motiondb::tests::unseen_dimensions_test
