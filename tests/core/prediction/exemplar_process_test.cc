#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "core/prediction/forecast.h"

namespace motiondb::tests::exemplar_process_test {

TEST_CASE("WeighExemplars: weights and variance equal those of kriging", "[core][prediction]") {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  const auto draw = [&](int rows, int columns) {
    return core::FrameMatrix::NullaryExpr(rows, columns, [&](auto, auto) { return normal(random); })
        .eval();
  };
  for (int round = 0; round < 20; ++round) {
    const core::FrameMatrix keys = draw(9, 4);
    const Eigen::RowVectorXf query = draw(1, 4);
    Eigen::MatrixXd kernel(9, 9);
    Eigen::VectorXd to_query(9);
    for (int i = 0; i < 9; ++i) {
      to_query[i] = std::exp(-(keys.row(i) - query).norm() / 0.7);
      for (int j = 0; j < 9; ++j) {
        kernel(i, j) = std::exp(-(keys.row(i) - keys.row(j)).norm() / 0.7) + (i == j ? 0.05 : 0);
      }
    }
    const Eigen::VectorXd expected = kernel.inverse() * to_query;
    const auto weighed = core::WeighExemplars(keys, query, 0.7, 0.05);
    CHECK((weighed.weights - expected).norm() < 1e-4);
    CHECK(weighed.variance == Approx(1 - to_query.dot(expected)).margin(1e-4));
  }
}

TEST_CASE("WeighExemplars: an example at the query has nearly all weight, distant ones none",
          "[core][prediction]") {
  core::FrameMatrix keys(2, 1);
  keys << 0, 100;
  const auto weighed = core::WeighExemplars(keys, Eigen::RowVectorXf::Zero(1), 0.5, 0.01);
  CHECK(weighed.weights[0] == Approx(1 / 1.01));
  CHECK(weighed.weights[1] == Approx(0).margin(1e-9));
  CHECK(weighed.variance == Approx(1 - 1 / 1.01));
}

}  // namespace motiondb::tests::exemplar_process_test
