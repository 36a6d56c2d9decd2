#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/recognition/metric_observation.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::seen_metric_test {
namespace {

Eigen::MatrixXd WithinBehaviours(const core::MotionMetric& metric) {
  const Eigen::MatrixXd inverse = (metric.whitening * metric.whitening.transpose()).cast<double>();
  return inverse.inverse();
}

}  // namespace

TEST_CASE("MetricOfSeen: equals the metric of the seen dimensions alone", "[core][recognition]") {
  const core::Model model = SmallModel(6, 200, 4, 8, 3);
  const core::MotionMetric& metric = model.metric();
  std::vector<Eigen::Index> seen;
  for (Eigen::Index d = 0; d < metric.mean.size(); ++d) {
    if (d / 6 != 1) seen.push_back(d);  // all of the second marker is missing
  }
  const core::MotionMetric own = core::MetricOfSeen(metric, seen);
  const Eigen::MatrixXd block = WithinBehaviours(metric)(seen, seen);
  const Eigen::MatrixXd whitening = own.whitening(seen, Eigen::all).cast<double>();
  const Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(block.rows(), block.cols());
  CHECK((whitening.transpose() * block * whitening - expected).norm() < 1e-2);
  const Eigen::MatrixXd projection = own.projection(seen, Eigen::all).cast<double>();
  CHECK((projection.transpose() * block * projection -
         Eigen::MatrixXd::Identity(projection.cols(), projection.cols()))
            .norm() < 1e-2);
  for (Eigen::Index d = 6; d < 12; ++d) {
    CHECK(own.whitening.row(d).isZero());
    CHECK(own.projection.row(d).isZero());
  }
  // If all dimensions are seen, distances in the kept directions do not change.
  std::vector<Eigen::Index> all(static_cast<std::size_t>(metric.mean.size()));
  std::iota(all.begin(), all.end(), 0);
  const core::MotionMetric same = core::MetricOfSeen(metric, all);
  const core::FrameMatrix apart = model.states().row(10) - model.states().row(300);
  CHECK((apart * same.whitening).norm() == Approx((apart * metric.whitening).norm()).epsilon(1e-3));
}

TEST_CASE("Recognize: a marker that is never seen has no effect", "[core][recognition]") {
  const core::Model model = SmallModel(6, 240, 5, 8, 31);
  for (int c = 0; c < 6; ++c) {
    core::StateSequence clip = WanderingClips(6, 240, model.marker_set(), 31)[c].states;
    clip.states.middleCols<6>(18).setConstant(std::nanf(""));
    const auto windows = core::Recognize(model, clip, {});
    REQUIRE(windows.ok());
    for (const core::RecognizedWindow& window : *windows) {
      CHECK(window.labels.front().label == (c % 2 == 0 ? "a" : "b"));
    }
  }
}

}  // namespace motiondb::tests::seen_metric_test
