#include "core/kinematics/singularity_robust.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

namespace motiondb::tests::singularity_robust_test {
namespace {

using core::SingularityRobustInverse;

// Adds J x = r, three rows at a time.
void AddAll(const Eigen::MatrixXd &jacobian, const Eigen::VectorXd &right_side,
            SingularityRobustInverse &inverse) {
  std::vector<int> unknowns(static_cast<std::size_t>(jacobian.cols()));
  std::iota(unknowns.begin(), unknowns.end(), 0);
  for (Eigen::Index row = 0; row < jacobian.rows(); row += 3) {
    const Eigen::Matrix3Xd columns = jacobian.middleRows<3>(row);
    inverse.Add(unknowns, columns, right_side.segment<3>(row));
  }
}

Eigen::MatrixXd Random(int rows, int columns, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return number(random); });
}

}  // namespace

TEST_CASE("SingularityRobustInverse: least squares for determined equations",
          "[core][kinematics]") {
  const Eigen::MatrixXd jacobian = Random(30, 12, 1);
  const Eigen::VectorXd right_side = Random(30, 1, 2);
  SingularityRobustInverse inverse(12);
  AddAll(jacobian, right_side, inverse);
  const Eigen::VectorXd expected = jacobian.colPivHouseholderQr().solve(right_side);
  CHECK((inverse.Solve() - expected).norm() < 1e-12);
  CHECK((inverse.gradient() - jacobian.transpose() * right_side).norm() < 1e-12);
  SECTION("with damping") {
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    normal.diagonal().array() += 0.3;
    const Eigen::VectorXd damped = normal.ldlt().solve(jacobian.transpose() * right_side);
    CHECK((inverse.Solve(0.3) - damped).norm() < 1e-12);
  }
  SECTION("with weights and a bias") {
    SingularityRobustInverse weighted(12);
    std::vector<int> unknowns(12);
    std::iota(unknowns.begin(), unknowns.end(), 0);
    Eigen::MatrixXd scaled = jacobian;
    Eigen::VectorXd scaled_side = right_side;
    for (Eigen::Index row = 0; row < 30; row += 3) {
      const double weight = 0.1 + static_cast<double>(row);
      weighted.Add(unknowns, jacobian.middleRows<3>(row), right_side.segment<3>(row), weight);
      scaled.middleRows<3>(row) *= std::sqrt(weight);
      scaled_side.segment<3>(row) *= std::sqrt(weight);
    }
    const Eigen::VectorXd towards = Random(12, 1, 9);
    weighted.AddPull(towards, 2.5);
    Eigen::MatrixXd normal = scaled.transpose() * scaled;
    normal.diagonal().array() += 2.5;
    const Eigen::VectorXd gradient = scaled.transpose() * scaled_side + 2.5 * towards;
    CHECK((weighted.gradient() - gradient).norm() < 1e-10);
    CHECK((weighted.Solve() - normal.ldlt().solve(gradient)).norm() < 1e-12);
  }
  SECTION("with fixed unknowns") {
    const double value = GENERATE(0.0, 0.7);
    inverse.Hold(3, value);
    inverse.Hold(11, -value);
    CHECK(inverse.IsHeld(3));
    CHECK_FALSE(inverse.IsHeld(4));
    Eigen::MatrixXd rest(30, 10);
    rest << jacobian.leftCols(3), jacobian.middleCols(4, 7);
    const Eigen::VectorXd solved = rest.colPivHouseholderQr().solve(
        right_side - value * jacobian.col(3) + value * jacobian.col(11));
    const Eigen::VectorXd x = inverse.Solve();
    CHECK(x[3] == value);
    CHECK(x[11] == -value);
    CHECK((x.head(3) - solved.head(3)).norm() < 1e-12);
    CHECK((x.segment(4, 7) - solved.tail(7)).norm() < 1e-12);
    inverse.Release();
    CHECK((inverse.Solve() - expected).norm() < 1e-12);
  }
}

TEST_CASE("SingularityRobustInverse: sparse equations equal dense ones", "[core][kinematics]") {
  // A root (0, 1), two limbs (2, 3) and (4, 5), and a marker that depends on both limbs.
  const std::vector<std::vector<int>> moved_by = {{0, 1, 2, 3}, {0, 1, 4, 5}, {0, 1}, {1, 2, 4}};
  SingularityRobustInverse inverse(6);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(12, 6);
  const Eigen::VectorXd right_side = Random(12, 1, 3);
  for (std::size_t m = 0; m < moved_by.size(); ++m) {
    const Eigen::Matrix3Xd columns = Random(3, static_cast<int>(moved_by[m].size()), 4 + m);
    const auto row = static_cast<Eigen::Index>(3 * m);
    for (std::size_t i = 0; i < moved_by[m].size(); ++i) {
      jacobian.block<3, 1>(row, moved_by[m][i]) = columns.col(static_cast<Eigen::Index>(i));
    }
    inverse.Add(moved_by[m], columns, right_side.segment<3>(row));
  }
  const Eigen::VectorXd expected = jacobian.colPivHouseholderQr().solve(right_side);
  CHECK((inverse.Solve() - expected).norm() < 1e-10);
}

TEST_CASE(
    "SingularityRobustInverse: damping grows towards a singularity and "
    "does not affect other unknowns",
    "[core][kinematics]") {
  // The second unknown moves the marker less and less; the plain inverse would grow without bound.
  double before = INFINITY;
  for (const double reach : {1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 0.0}) {
    SingularityRobustInverse inverse(3);
    Eigen::MatrixXd jacobian(3, 3);
    jacobian << 1, 0, 0, 0, reach, 0, 0, 0, 1;
    AddAll(jacobian, Eigen::Vector3d(1, 0.01, 2), inverse);
    const Eigen::VectorXd x = inverse.Solve();
    CHECK(x[0] == Approx(1));
    CHECK(x[2] == Approx(2));
    if (reach >= 1e-2) CHECK(x[1] == Approx(0.01 / reach));
    CHECK(std::abs(x[1]) < 2.5);        // peak is halfway; the plain inverse has 10000 at 1e-6
    const double share = x[1] * reach;  // fraction of the marker's distance that is covered
    CHECK(share <= before + 1e-12);
    before = share;
  }
  CHECK(before == 0);
}

TEST_CASE("SingularityRobustInverse: no equations, no motion", "[core][kinematics]") {
  SingularityRobustInverse inverse(5);
  CHECK(inverse.Solve().isZero());
}

}  // namespace motiondb::tests::singularity_robust_test
