#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "core/estimation/estimate.h"

namespace motiondb::tests::local_regression_test {
namespace {

Eigen::MatrixXd Random(int rows, int columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&](auto, auto) { return normal(random); });
}

}  // namespace

TEST_CASE("Regress: the dual form equals primal ridge regression", "[core][estimation]") {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    const Eigen::MatrixXd known = Random(12, 5, random);
    const Eigen::MatrixXd targets = Random(12, 3, random);
    Eigen::VectorXd weights = Random(12, 1, random).cwiseAbs();
    weights /= weights.sum();
    const Eigen::VectorXd at = Random(5, 1, random);

    const Eigen::RowVectorXd x_mean = weights.transpose() * known;
    const Eigen::RowVectorXd y_mean = weights.transpose() * targets;
    const Eigen::MatrixXd x = known.rowwise() - x_mean;
    const Eigen::MatrixXd y = targets.rowwise() - y_mean;
    const Eigen::MatrixXd gram =
        x.transpose() * weights.asDiagonal() * x + 0.3 * Eigen::MatrixXd::Identity(5, 5);
    const Eigen::VectorXd expected =
        y_mean.transpose() +
        (gram.inverse() * x.transpose() * weights.asDiagonal() * y).transpose() *
            (at - x_mean.transpose());

    const auto regressed = core::Regress(known, targets, weights, at, 0.3);
    CHECK((regressed.mean - expected).norm() < 1e-9);
    CHECK((regressed.variance.array() > 0).all());
  }
}

TEST_CASE("Regress: dependent values are predicted with a correct variance", "[core][estimation]") {
  std::mt19937 random(8);
  const Eigen::MatrixXd map = Random(4, 2, random);
  double squares = 0;
  double expected = 0;
  for (int round = 0; round < 200; ++round) {
    const Eigen::MatrixXd known = Random(40, 4, random);
    const Eigen::MatrixXd targets = known * map + 0.1 * Random(40, 2, random);
    const Eigen::VectorXd at = Random(4, 1, random);
    const Eigen::VectorXd truth = map.transpose() * at + 0.1 * Random(2, 1, random);
    const auto regressed =
        core::Regress(known, targets, Eigen::VectorXd::Constant(40, 1.0 / 40), at, 1e-3);
    squares += (regressed.mean - truth).squaredNorm();
    expected += regressed.variance.sum();
  }
  CHECK(squares / 400 < 0.015);
  CHECK(expected > 0.8 * squares);
  CHECK(expected < 1.8 * squares);
}

TEST_CASE("Regress: without known values the result is the mean", "[core][estimation]") {
  Eigen::MatrixXd targets(2, 1);
  targets << 1, 3;
  const auto regressed = core::Regress(Eigen::MatrixXd(2, 0), targets, Eigen::Vector2d(0.25, 0.75),
                                       Eigen::VectorXd(0), 0.1);
  CHECK(regressed.mean[0] == Approx(2.5));
}

}  // namespace motiondb::tests::local_regression_test
