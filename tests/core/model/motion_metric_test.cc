#include "core/model/motion_metric.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/model/label_units.h"
#include "core/model/metric_frames.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::motion_metric_test {
namespace {

// Runs the parts in reverse order.
void RunBackwards(int count, const std::function<void(int)>& body) {
  for (int i = count - 1; i >= 0; --i) body(i);
}

// Returns 0.8 W + 0.2 (tr W / D) I, computed directly from the pairs.
Eigen::MatrixXd WithinBehaviours(const core::Model& model) {
  const auto rows = core::StrideFrames(model.clips(), model.settings().frame_rate_hz);
  const auto frames_of = [&](int clip) -> core::FrameMatrix {
    const std::vector<int> frames(rows.frame.begin() + rows.begin[clip],
                                  rows.frame.begin() + rows.begin[clip + 1]);
    return model.states()(frames, Eigen::all);
  };
  const Eigen::Index dimensions = model.states().cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(dimensions, dimensions);
  double count = 0;
  for (const auto& clips : core::UnitPairs(model.action_units()->all())) {
    const core::FrameMatrix a = frames_of(clips.observed);
    const core::FrameMatrix b = frames_of(clips.reference);
    for (const auto& pair : core::AlignFrames(a, b)) {
      const Eigen::RowVectorXd d = (a.row(pair.observed) - b.row(pair.reference)).cast<double>();
      sum += d.transpose() * d;
      ++count;
    }
  }
  sum /= 2 * count;
  const double mean = sum.trace() / static_cast<double>(dimensions);
  return 0.8 * sum + 0.2 * mean * Eigen::MatrixXd::Identity(dimensions, dimensions);
}

}  // namespace

TEST_CASE("FrameStride: about 30 frames a second", "[core][model]") {
  CHECK(core::FrameStride(10) == 1);
  CHECK(core::FrameStride(30) == 1);
  CHECK(core::FrameStride(60) == 2);
  CHECK(core::FrameStride(100) == 3);
  CHECK(core::FrameStride(120) == 4);
}

TEST_CASE("MotionMetric: differences within behaviours have unit variances", "[core][model]") {
  const core::Model model = SmallModel(6, 200, 8, 8, 5);
  const core::MotionMetric& metric = model.metric();
  REQUIRE(metric.whitening.rows() == 48);
  REQUIRE(metric.projection.cols() == 40);
  const Eigen::MatrixXd within = WithinBehaviours(model);
  const Eigen::MatrixXd whitening = metric.whitening.cast<double>();
  CHECK((whitening.transpose() * within * whitening).isIdentity(1e-3));
  const Eigen::MatrixXd projection = metric.projection.cast<double>();
  CHECK((projection.transpose() * within * projection).isIdentity(1e-3));
  CHECK(metric.mean.size() == 48);
  CHECK(metric.loadings.cols() == 30);
  CHECK(metric.noise >= 1e-4);
  CHECK(SmallModel(2, 60, 2, 8, 5).metric().projection.cols() == 12);
}

TEST_CASE("MotionMetric: separates behaviours that vary more than they differ", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  std::vector<core::BuildInput> inputs = WanderingClips(16, 90, set, 9);
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    core::FrameMatrix& states = inputs[c].states.states;
    states = WanderingStates(90, set.dimension_count(), 9);  // equal for all clips
    // Then a large random offset in 18 dimensions, and a small one in 6 that depends on the label.
    for (Eigen::Index d = 0; d < 18; ++d) states.col(d).array() += 3 * normal(random);
    states.rightCols(6).array() += c % 2 == 0 ? 0.5F : -0.5F;
  }
  const auto model = core::BuildModel({}, set, std::move(inputs), core::RunSerially, {});
  REQUIRE(model.ok());
  const auto count_correct = [&](const core::FrameMatrix& frames) {
    int count = 0;
    const Eigen::Index frames_per_clip = frames.rows() / 16;
    for (int c = 0; c < 16; ++c) {
      double min_distance = 1e30;
      int nearest = 0;
      for (int o = 0; o < 16; ++o) {
        const double distance = (frames.middleRows(c * frames_per_clip, frames_per_clip) -
                                 frames.middleRows(o * frames_per_clip, frames_per_clip))
                                    .squaredNorm();
        if (o != c && distance < min_distance) {
          min_distance = distance;
          nearest = o;
        }
      }
      count += nearest % 2 == c % 2 ? 1 : 0;
    }
    return count;
  };
  CHECK(count_correct(model->states()) < 14);
  CHECK(count_correct(model->metric_frames().projected.view()) == 16);
}

TEST_CASE("MotionMetric: independent of the execution order", "[core][model]") {
  const core::Model model = SmallModel(6, 150, 5, 8, 2);
  const core::MotionMetric again = core::FitMotionMetric(model.parts(), RunBackwards);
  CHECK(again.mean == model.metric().mean);
  CHECK(again.loadings == model.metric().loadings);
  CHECK(again.noise == model.metric().noise);
  CHECK(again.whitening == model.metric().whitening);
  CHECK(again.projection == model.metric().projection);
}

TEST_CASE("MotionMetric: exists for single clips and for motion without movement",
          "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(3);
  const auto metric = [&](int frames, bool still) {
    std::vector<core::BuildInput> inputs = WanderingClips(2, frames, set, 7);
    if (still) {
      for (auto& input : inputs) input.states.states.setOnes();
    }
    const auto model = core::BuildModel({}, set, std::move(inputs), core::RunSerially, {});
    REQUIRE(model.ok());
    CHECK(model->metric().projection.allFinite());
    CHECK(model->metric().whitening.allFinite());
    CHECK(model->metric().loadings.allFinite());
    CHECK(model->metric_frames().projected.view().allFinite());
  };
  metric(60, false);
  metric(60, true);
  metric(1, false);
}

}  // namespace motiondb::tests::motion_metric_test
