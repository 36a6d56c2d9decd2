#include "core/tree/principal_axis.h"

#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <random>

namespace motiondb::tests::principal_axis_test {
namespace {

Eigen::MatrixXd RandomData(int dimensions, int frames, unsigned seed, double decay) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd data(dimensions, frames);
  for (Eigen::Index i = 0; i < data.size(); ++i) data.data()[i] = normal(random);
  for (int d = 0; d < dimensions; ++d) data.row(d) *= std::pow(decay, d);
  data.colwise() -= data.rowwise().mean().eval();
  return data;
}

core::PrincipalAxis Find(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& start,
                         double tolerance) {
  return core::FindPrincipalAxis(
      [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y = matrix * x; }, start, tolerance);
}

}  // namespace

TEST_CASE("PrincipalAxis: is the first left singular vector of the centred data", "[core][tree]") {
  for (const double decay : {0.5, 0.9, 0.99, 1.0}) {
    for (const int dimensions : {2, 6, 40, 204}) {
      for (const int frames : {3, 16, 300}) {
        const Eigen::MatrixXd data = RandomData(dimensions, frames, 7, decay);
        const Eigen::VectorXd start = Eigen::VectorXd::Ones(dimensions);
        const Eigen::VectorXd axis = Find(data * data.transpose(), start, 1e-6).axis;
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(data, Eigen::ComputeThinU);
        CAPTURE(decay, dimensions, frames);
        CHECK(axis.norm() == Approx(1));
        CHECK(std::abs(axis.dot(svd.matrixU().col(0))) == Approx(1).margin(1e-6));
        Eigen::Index largest = 0;
        axis.cwiseAbs().maxCoeff(&largest);
        CHECK(axis[largest] > 0);
      }
    }
  }
}

TEST_CASE("PrincipalAxis: its residual, variance and angle are within its stated bounds",
          "[core][tree]") {
  for (const double decay : {0.3, 0.8, 0.97}) {
    for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-6}) {
      for (unsigned seed = 0; seed < 20; ++seed) {
        const Eigen::MatrixXd data = RandomData(50, 200, seed, decay);
        const Eigen::MatrixXd matrix = data * data.transpose();
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(data, Eigen::ComputeThinU);
        const Eigen::VectorXd values = svd.singularValues().cwiseAbs2();
        const core::PrincipalAxis found = Find(matrix, matrix.col(0), tolerance);
        CAPTURE(decay, tolerance, seed);
        CHECK(found.residual <= tolerance);
        CHECK((matrix * found.axis - found.variance * found.axis).norm() <=
              tolerance * found.variance * (1 + 1e-6));
        CHECK(found.axis.dot(matrix * found.axis) == Approx(found.variance));
        CHECK((values.array() - found.variance).abs().minCoeff() <= tolerance * found.variance);
        const Eigen::VectorXd axis = svd.matrixU().col(0);
        const double sine = (found.axis - axis * axis.dot(found.axis)).norm();
        if (found.variance > values[1]) {
          CHECK(sine <= found.residual * found.variance / (found.variance - values[1]) + 1e-7);
        }
      }
    }
  }
}

TEST_CASE("PrincipalAxis: a start near the axis needs fewer products", "[core][tree]") {
  const Eigen::MatrixXd data = RandomData(60, 300, 3, 0.95);
  const Eigen::MatrixXd matrix = data * data.transpose();
  const core::PrincipalAxis cold = Find(matrix, Eigen::VectorXd::Ones(60), 1e-4);
  const core::PrincipalAxis warm = Find(matrix, cold.axis, 1e-3);
  CHECK(cold.products > 3);
  CHECK(warm.products == 1);
}

TEST_CASE("PrincipalAxis: a zero matrix has an axis too", "[core][tree]") {
  const core::PrincipalAxis found =
      Find(Eigen::MatrixXd::Zero(5, 5), Eigen::VectorXd::Unit(5, 0), 1e-6);
  CHECK(found.axis == Eigen::VectorXd::Unit(5, 0));
  CHECK(found.variance == 0);
  CHECK(found.residual == 0);
}

TEST_CASE("PrincipalAxis: two axes of equal length give one in their plane", "[core][tree]") {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(4, 4);
  covariance(0, 0) = covariance(1, 1) = 5;
  const Eigen::VectorXd axis = Find(covariance, Eigen::VectorXd::Ones(4), 1e-9).axis;
  CHECK(axis.head<2>().norm() == Approx(1));
}

TEST_CASE("PrincipalAxis: a matrix of rank 1 needs two products", "[core][tree]") {
  const Eigen::VectorXd axis = Eigen::VectorXd::LinSpaced(30, 1, 5).normalized();
  const core::PrincipalAxis found =
      Find(3 * axis * axis.transpose(), Eigen::VectorXd::Unit(30, 4), 1e-6);
  CHECK(found.products <= 2);
  CHECK(found.axis.isApprox(axis));
  CHECK(found.variance == Approx(3));
}

}  // namespace motiondb::tests::principal_axis_test
