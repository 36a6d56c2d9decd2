#include <catch2/catch.hpp>
#include <random>

#include "core/kinematics/pose_solver.h"

namespace motiondb::tests::rigid_fit_test {
namespace {

Eigen::Matrix3Xd Points(int count) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  return Eigen::Matrix3Xd::NullaryExpr(3, count, [&] { return number(random); });
}

Eigen::Isometry3d Moved() {
  return Eigen::Translation3d(3, -2, 1) *
         Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, 2, 3).normalized());
}

}  // namespace

TEST_CASE("FitRigid: finds the motion that moved the points", "[core][kinematics]") {
  const Eigen::Matrix3Xd from = Points(6);
  Eigen::Matrix3Xd to = Moved() * from;
  Eigen::VectorXd weights(6);
  weights << 1, 2, 0.1, 1, 3, 0;
  to.col(5).setConstant(100);  // has no weight
  const Eigen::Isometry3d fit = core::FitRigid(from, to, weights);
  CHECK((fit * from - to).leftCols<5>().cwiseAbs().maxCoeff() < 1e-4);
  CHECK(fit.linear().isUnitary(1e-12));
  CHECK(fit.linear().determinant() == Approx(1));
}

TEST_CASE("FitRigid: points in a plane, on a line, one point, none", "[core][kinematics]") {
  Eigen::Matrix3Xd from = Points(4);
  from.row(2).setZero();
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(4);
  CHECK((core::FitRigid(from, Moved() * from, weights) * from - Moved() * from).norm() < 1e-4);
  SECTION("a line has the minimum rotation") {
    from.bottomRows<2>().setZero();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).matrix();
    const Eigen::Isometry3d fit = core::FitRigid(from, turn * from, weights);
    CHECK((fit.linear() - turn).norm() < 1e-3);
  }
  SECTION("one point has no rotation") {
    const Eigen::Isometry3d fit =
        core::FitRigid(from.leftCols<1>(), Moved() * from.leftCols<1>(), weights.head<1>());
    CHECK(fit.linear().isIdentity(1e-12));
    CHECK((fit * from.col(0) - Moved() * from.col(0)).norm() < 1e-12);
  }
  SECTION("no points: identity") {
    CHECK(core::FitRigid(from, Moved() * from, Eigen::VectorXd::Zero(4))
              .isApprox(Eigen::Isometry3d::Identity()));
  }
}

}  // namespace motiondb::tests::rigid_fit_test
