// Oracle: an eigendecomposition of the covariance in double precision.
#include "core/view/model_picture.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>

#include "tests/support/synthetic_states.h"
#include "tests/support/threads.h"

namespace motiondb::tests::model_picture_test {
namespace {

// Normal states with clearly different variances along random directions, far from the origin.
core::FrameMatrix SpreadStates(int frames, int dimensions, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto drawn = [&](int rows, int columns) {
    Eigen::MatrixXd values(rows, columns);
    for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = normal(random);
    return values;
  };
  const Eigen::MatrixXd basis =
      Eigen::HouseholderQR<Eigen::MatrixXd>(drawn(dimensions, dimensions)).householderQ();
  Eigen::RowVectorXd deviations(dimensions);
  for (int d = 0; d < dimensions; ++d) deviations[d] = 4 / (1.0 + d);
  Eigen::MatrixXd states = drawn(frames, dimensions);
  states.array().rowwise() *= deviations.array();
  states = states * basis.transpose();
  states.rowwise() += 5 * drawn(1, dimensions).row(0);
  return states.cast<float>();
}

void CheckAgainstOracle(const core::FrameMatrix& states, const core::StateAxes& found) {
  const Eigen::MatrixXd exact = states.cast<double>();
  const Eigen::RowVectorXd mean = exact.colwise().mean();
  const Eigen::MatrixXd centred = exact.rowwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centred.transpose() * centred /
                                                              static_cast<double>(states.rows()));
  const Eigen::Index dimensions = states.cols();
  const auto kept = std::min<Eigen::Index>(core::kReportedAxes, dimensions);
  CHECK((found.mean.transpose() - mean).cwiseAbs().maxCoeff() < 1e-5);
  REQUIRE(found.axes.cols() == kept);
  REQUIRE(found.variance_fractions.size() == kept);
  REQUIRE(found.projections.rows() == states.rows());
  REQUIRE(found.projections.cols() == core::kDrawnAxes);
  for (Eigen::Index i = 0; i < kept; ++i) {
    Eigen::VectorXd axis = solver.eigenvectors().col(dimensions - 1 - i);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    if (axis[largest] < 0) axis = -axis;
    CHECK((found.axes.col(i) - axis).norm() < 1e-4);
    CHECK(found.variance_fractions[i] ==
          Approx(solver.eigenvalues()[dimensions - 1 - i] / solver.eigenvalues().sum())
              .epsilon(1e-5));
    if (i >= core::kDrawnAxes) continue;
    const Eigen::VectorXd projected = centred * axis;
    CHECK((found.projections.col(i).cast<double>() - projected).cwiseAbs().maxCoeff() < 2e-3);
  }
}

TEST_CASE("FindStateAxes: the eigenvectors of the covariance", "[core][view]") {
  for (const auto& [frames, dimensions] :
       std::vector<std::pair<int, int>>{{2000, 12}, {5000, 60}, {700, 204}, {13, 6}}) {
    INFO(frames << " x " << dimensions);
    const core::FrameMatrix states = SpreadStates(frames, dimensions, 7);
    const auto found = core::FindStateAxes(states);
    REQUIRE(found.ok());
    CheckAgainstOracle(states, *found);
  }
}

TEST_CASE("FindStateAxes: does not depend on threads", "[core][view]") {
  const core::FrameMatrix states = WanderingStates(4000, 30, 3);
  const auto serial = core::FindStateAxes(states);
  const auto threaded = core::FindStateAxes(states, RunOnThreads(3));
  REQUIRE((serial.ok() && threaded.ok()));
  CHECK(serial->axes == threaded->axes);
  CHECK(serial->projections == threaded->projections);
  CHECK(serial->variance_fractions == threaded->variance_fractions);
}

TEST_CASE("FindStateAxes: does not depend on the order of frames", "[core][view]") {
  const core::FrameMatrix states = SpreadStates(3000, 24, 11);
  const core::FrameMatrix reversed = states.colwise().reverse();
  const auto forth = core::FindStateAxes(states);
  const auto back = core::FindStateAxes(reversed);
  REQUIRE((forth.ok() && back.ok()));
  CHECK((forth->axes - back->axes).cwiseAbs().maxCoeff() < 1e-5);
  CHECK((forth->projections - back->projections.colwise().reverse()).cwiseAbs().maxCoeff() < 1e-3F);
}

TEST_CASE("FindStateAxes: equal states, one state, and no state", "[core][view]") {
  for (const int frames : {0, 1, 100}) {
    const core::FrameMatrix states = core::FrameMatrix::Constant(frames, 12, 3.5F);
    const auto found = core::FindStateAxes(states);
    REQUIRE(found.ok());
    CHECK(found->variance_fractions.isZero());
    CHECK(found->projections.rows() == frames);
    CHECK((frames == 0 || found->projections.cwiseAbs().maxCoeff() < 1e-5F));
    CHECK(found->axes.allFinite());
  }
}

TEST_CASE("FindStateAxes: is cancelled between blocks", "[core][view]") {
  const core::FrameMatrix states = WanderingStates(20000, 12, 3);
  int calls = 0;
  const auto found =
      core::FindStateAxes(states, core::RunSerially, [&calls] { return ++calls > 3; });
  CHECK(absl::IsCancelled(found.status()));
  CHECK(calls == 4);
}

}  // namespace
}  // namespace motiondb::tests::model_picture_test
