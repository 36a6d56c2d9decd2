#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "core/tree/principal_axis.h"

namespace motiondb::tests::tridiagonal_test {
namespace {

struct Tridiagonal {
  std::vector<double> diagonal;
  std::vector<double> beside;

  Eigen::MatrixXd Full() const {
    const auto n = static_cast<Eigen::Index>(diagonal.size());
    Eigen::MatrixXd full = Eigen::VectorXd::Map(diagonal.data(), n).asDiagonal();
    for (Eigen::Index i = 0; i + 1 < n; ++i) full(i, i + 1) = full(i + 1, i) = beside[i];
    return full;
  }
};

// As in the Lanczos method: positive off-diagonal elements.
Tridiagonal RandomTridiagonal(int size, double decay, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.2, 1);
  Tridiagonal matrix;
  for (int i = 0; i < size; ++i) {
    matrix.diagonal.push_back(uniform(random) * std::pow(decay, i));
    matrix.beside.push_back(0.5 * uniform(random) * std::pow(decay, i));
  }
  return matrix;
}

}  // namespace

TEST_CASE("Tridiagonal: top eigenvalue and vector equal the full decomposition's", "[core][tree]") {
  for (const int size : {1, 2, 3, 7, 20, 60, 204}) {
    for (const double decay : {0.5, 0.8, 0.97, 1.0}) {
      for (unsigned seed = 0; seed < 10; ++seed) {
        const Tridiagonal matrix = RandomTridiagonal(size, decay, seed);
        const Eigen::MatrixXd full = matrix.Full();
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(full);
        CAPTURE(size, decay, seed);
        const core::TridiagonalTop top = core::TopOfTridiagonal(matrix.diagonal, matrix.beside);
        CHECK(top.value == Approx(solver.eigenvalues()[size - 1]).epsilon(1e-12));
        CHECK(top.vector.norm() == Approx(1));
        CHECK((full * top.vector - top.value * top.vector).norm() <= 1e-12 * top.value);
        const double last = std::abs(solver.eigenvectors()(size - 1, size - 1));
        CHECK(std::abs(top.vector[size - 1]) == Approx(last).epsilon(1e-6).margin(1e-13));
      }
    }
  }
}

TEST_CASE("Tridiagonal: a diagonal of zeros, and numbers of any size", "[core][tree]") {
  const std::vector<double> zeros(5, 0.0);
  const std::vector<double> ones(5, 1.0);
  CHECK(core::TopOfTridiagonal(zeros, ones).value == Approx(2 * std::cos(std::acos(-1) / 6)));
  for (const double scale : {1e-30, 1e30}) {
    const std::vector<double> diagonal{2 * scale, 2 * scale};
    const std::vector<double> beside{scale};
    const core::TridiagonalTop top = core::TopOfTridiagonal(diagonal, beside);
    CHECK(top.value == Approx(3 * scale));
    CHECK(std::abs(top.vector[1]) == Approx(std::sqrt(0.5)));
  }
  CHECK(core::TopOfTridiagonal(std::vector<double>{0.0}, {}).value == 0.0);
}

}  // namespace motiondb::tests::tridiagonal_test
