#include "core/tree/principal_axis.h"

#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <random>

namespace motiondb::tests {
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

}  // namespace

TEST_CASE("PrincipalAxis: is the first left singular vector of the centred data", "[core][tree]") {
  for (const double decay : {0.5, 0.9, 0.99, 1.0}) {
    for (const int dimensions : {2, 6, 40, 204}) {
      for (const int frames : {3, 16, 300}) {
        const Eigen::MatrixXd data = RandomData(dimensions, frames, 7, decay);
        const Eigen::VectorXd axis = core::PrincipalAxis(data * data.transpose());
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

TEST_CASE("PrincipalAxis: a zero matrix has an axis too", "[core][tree]") {
  CHECK(core::PrincipalAxis(Eigen::MatrixXd::Zero(5, 5)) == Eigen::VectorXd::Unit(5, 0));
}

TEST_CASE("PrincipalAxis: two axes of equal length give one of their plane", "[core][tree]") {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(4, 4);
  covariance(0, 0) = covariance(1, 1) = 5;
  const Eigen::VectorXd axis = core::PrincipalAxis(covariance);
  CHECK(axis.head<2>().norm() == Approx(1));
}

}  // namespace motiondb::tests
