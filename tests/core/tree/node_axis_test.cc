#include <catch2/catch.hpp>
#include <cmath>

#include "core/tree/principal_axis.h"
#include "core/tree/row_kernels.h"
#include "core/tree/tree_builder.h"
#include "tests/core/tree/exact_split.h"
#include "tests/core/tree/real_states.h"
#include "tests/core/tree/threads.h"
#include "tests/support/real_data.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::node_axis_test {
namespace {

constexpr int kDimensions = 48;
constexpr double kRounding = 3e-6;  // single precision, relative to the largest scatter

core::NodeAxis AxisOf(const core::FrameMatrix& states,
                      const core::ParallelFor& parallel = core::RunSerially) {
  core::FrameMatrix padded(states.rows() + core::kRowLanes, states.cols());
  padded.topRows(states.rows()) = states;
  padded.bottomRows(core::kRowLanes).setConstant(1e6);  // is read, but must not matter
  std::vector<float> scratch;
  return core::FindNodeAxis(
      {padded.data(), static_cast<int>(states.rows()), static_cast<int>(states.cols())}, scratch,
      parallel);
}

// Checks that the axis is within its stated bounds and that its best cut is as good as the exact
// axis's. The cuts are not compared if another axis has almost the same scatter.
void CheckSplit(const core::FrameMatrix& states, bool compare_cuts = true) {
  const bool tight = states.rows() <= core::kTightFrames;
  const double tolerance = tight ? core::kTightTolerance : core::kLooseTolerance;
  const ExactAxes exact = FindExactAxes(states);
  const double largest = exact.scatters.tail<1>()[0];
  const double second = exact.scatters[exact.scatters.size() - 2];
  const core::NodeAxis node = AxisOf(states);
  const Eigen::VectorXd& axis = node.principal.axis;
  CAPTURE(states.rows(), largest / exact.total(), second / largest, node.principal.residual);

  CHECK((node.mean.transpose() - exact.mean).norm() <=
        1e-6 * (exact.mean.norm() + std::sqrt(largest / static_cast<double>(states.rows()))));
  CHECK(node.principal.residual <= tolerance);
  const Eigen::VectorXd product =
      exact.axes * (exact.scatters.asDiagonal() * (exact.axes.transpose() * axis));
  const double scatter = axis.dot(product);
  CHECK((product - scatter * axis).norm() <= (tolerance + kRounding) * scatter);
  const Eigen::VectorXd true_axis = exact.axes.rightCols<1>();
  const double sine = (axis - true_axis * true_axis.dot(axis)).norm();
  CHECK(sine * (scatter - second) <= (tolerance + kRounding) * scatter);
  CHECK(scatter >= largest * (1 - (tight ? 1e-9 : tolerance)));

  if (!compare_cuts) return;
  const double cost = MinCutCost(SortedProjections(states, exact.mean, axis));
  const double exact_cost = MinCutCost(SortedProjections(states, exact.mean, true_axis));
  CHECK(cost <= exact_cost + (tight ? 1e-6 : 1e-3) * static_cast<double>(states.rows()));
}

}  // namespace

TEST_CASE("NodeAxis: axis and split are as good as the exact ones", "[core][tree]") {
  for (const int frames : {4, 33, 500, 4096, 4097, 9000, 20'000, 40'000}) {
    CheckSplit(WanderingStates(frames, kDimensions, static_cast<unsigned>(frames)));
  }
}

TEST_CASE("NodeAxis: is accurate far from the origin", "[core][tree]") {
  for (const int frames : {300, 6000, 20'000}) {
    core::FrameMatrix states = WanderingStates(frames, kDimensions, 8);
    states.rowwise() += Eigen::RowVectorXf::LinSpaced(kDimensions, -5, 5);
    CheckSplit(states);
  }
}

TEST_CASE("NodeAxis: two axes of almost the same scatter", "[core][tree]") {
  for (const int frames : {1000, 30'000}) {
    core::FrameMatrix states = core::FrameMatrix::Random(frames, kDimensions);
    states.col(3) *= 3;
    states.col(17) *= 3.01f;
    CheckSplit(states, /*compare_cuts=*/false);
  }
}

TEST_CASE("NodeAxis: does not depend on threads", "[core][tree]") {
  for (const int frames : {1000, 10'000, 50'000}) {
    const core::FrameMatrix states = WanderingStates(frames, kDimensions, 4);
    const core::NodeAxis serial = AxisOf(states);
    const core::NodeAxis four = AxisOf(states, OnFourThreads);
    CHECK(serial.mean == four.mean);
    CHECK(serial.principal.axis == four.principal.axis);
  }
}

TEST_CASE("NodeAxis: equal frames have an axis", "[core][tree]") {
  for (const int frames : {1, 100, 5000}) {
    const core::NodeAxis node = AxisOf(core::FrameMatrix::Constant(frames, kDimensions, 0.5f));
    CHECK(node.mean == Eigen::VectorXd::Constant(kDimensions, 0.5));
    CHECK(node.principal.axis.norm() == Approx(1));
  }
}

TEST_CASE("NodeAxis: as good as exact in the nodes of real motion", "[core][tree][data][slow]") {
  MOTIONDB_REQUIRE_DATA();
  for (const core::FrameMatrix& states :
       {LoadScaledStates("sets/database1.train.tsv", 60),
        LoadScaledStates("sets/database2.tsv", 240), LoadScaledStates("index.tsv", 120, IsHdm05)}) {
    const auto tree = core::BuildTree(states, 16, core::RunSerially);
    REQUIRE(tree.ok());
    int checked = 0;
    for (const core::Branch& branch : tree->branches()) {
      if (branch.left < 0 || checked++ >= 40) continue;  // large ones come first
      core::FrameMatrix rows(branch.end - branch.begin, states.cols());
      for (int i = branch.begin; i < branch.end; ++i) {
        rows.row(i - branch.begin) = states.row(tree->frame_order()[i]);
      }
      CheckSplit(rows);
    }
  }
}

}  // namespace motiondb::tests::node_axis_test
