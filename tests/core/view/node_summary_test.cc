// Oracle: exhaustive statistics of the frames of each node.
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "core/model/model.h"
#include "core/view/model_picture.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::node_summary_test {
namespace {

std::vector<int> FramesOf(const core::Model& model, int layer, int node) {
  std::vector<int> frames;
  for (int frame = 0; frame < model.frame_count(); ++frame) {
    if (model.tree().node_of_frame(layer, frame) == node) frames.push_back(frame);
  }
  return frames;
}

void CheckEllipsoid(const core::StateAxes& axes, const std::vector<int>& frames,
                    const core::NodeSummary& summary) {
  const Eigen::MatrixXd points = axes.projections(frames, Eigen::all).cast<double>();
  const Eigen::RowVectorXd mean = points.colwise().mean();
  CHECK((summary.mean.cast<double>() - mean).norm() < 1e-5);
  const Eigen::MatrixXd centred = points.rowwise() - mean;
  const Eigen::Matrix3d covariance =
      centred.transpose() * centred / static_cast<double>(frames.size());
  // The ellipsoid of one standard deviation: A^T A is the covariance, with A's rows as semi-axes.
  const Eigen::Matrix3d semi_axes = summary.semi_axes.cast<double>();
  const double size = 1 + covariance.norm();
  CHECK((semi_axes.transpose() * semi_axes - covariance).norm() < 1e-5 * size);
  for (int i = 0; i < 3; ++i) {
    if (i > 0) {
      CHECK(semi_axes.row(i).norm() <= semi_axes.row(i - 1).norm() + 1e-6);
      CHECK(std::abs(semi_axes.row(i).dot(semi_axes.row(i - 1))) < 1e-5 * size);
    }
    Eigen::Index largest = 0;
    semi_axes.row(i).cwiseAbs().maxCoeff(&largest);
    CHECK(semi_axes(i, largest) >= 0);
  }
}

void CheckClips(const core::Model& model, const std::vector<int>& frames,
                const core::NodeSummary& summary) {
  std::map<int, int> of_clip;
  std::map<std::string, int> of_label;
  for (const int frame : frames) {
    const int clip = model.clip_of_frame(frame);
    ++of_clip[clip];
    ++of_label[model.clips()[clip].label()];
  }
  int best = of_clip.begin()->first;
  for (const auto& [clip, count] : of_clip) {
    if (count > of_clip[best]) best = clip;
  }
  CHECK(summary.frame_count == static_cast<int>(frames.size()));
  CHECK(summary.main_clip == best);
  CHECK(summary.label_fraction ==
        Approx(of_label[model.clips()[best].label()] / static_cast<double>(frames.size())));
}

TEST_CASE("NodeSummaries: equal exhaustive statistics in all layers", "[core][view]") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const core::Model model = SmallModel(6, 150, 5, 8, seed);
    const auto axes = core::FindStateAxes(model.states());
    REQUIRE(axes.ok());
    core::NodeSummaries summaries(model, *axes);
    REQUIRE(model.layer_count() > 2);
    for (int layer = 1; layer <= model.layer_count(); ++layer) {
      for (int node = 0; node < model.tree().node_count(layer); ++node) {
        INFO("layer " << layer << ", node " << node);
        const std::vector<int> frames = FramesOf(model, layer, node);
        const core::NodeSummary summary = summaries.Summarize(layer, node);
        CheckEllipsoid(*axes, frames, summary);
        CheckClips(model, frames, summary);
      }
    }
  }
}

TEST_CASE("NodeSummaries: the root has the variance of all states", "[core][view]") {
  const core::Model model = SmallModel(4, 200, 4, 16, 9);
  const auto axes = core::FindStateAxes(model.states());
  REQUIRE(axes.ok());
  const core::NodeSummary root = core::NodeSummaries(model, *axes).Summarize(1, 0);
  CHECK(root.mean.norm() < 1e-4F);
  // Along the principal axes themselves.
  for (int i = 0; i < 3; ++i) {
    const float length = root.semi_axes.row(i).norm();
    CHECK(root.semi_axes(i, i) == Approx(length).epsilon(1e-3));
  }
  const double first = root.semi_axes.row(0).squaredNorm();
  const double second = root.semi_axes.row(1).squaredNorm();
  CHECK(second / first ==
        Approx(axes->variance_fractions[1] / axes->variance_fractions[0]).epsilon(1e-3));
}

TEST_CASE("MeanPoseOf: the mean of the node's states, in metres", "[core][view]") {
  const core::Model model = SmallModel(3, 120, 5, 8, 5);
  const int layer = model.layer_count();
  for (int node = 0; node < model.tree().node_count(layer); ++node) {
    const std::vector<int> frames = FramesOf(model, layer, node);
    core::FrameMatrix states = model.states()(frames, Eigen::all);
    model.scale().Revert(states);
    const Eigen::RowVectorXd mean = states.cast<double>().colwise().mean() * 0.9;  // leg length
    const core::MeanPose pose = core::MeanPoseOf(model, layer, node);
    REQUIRE(pose.positions_m.size() == 15);
    for (int m = 0; m < 5; ++m) {
      CHECK((pose.positions_m.segment<3>(3 * m).cast<double>() - mean.segment<3>(6 * m)).norm() <
            1e-4);
      CHECK((pose.velocities_m_s.segment<3>(3 * m).cast<double>() - mean.segment<3>(6 * m + 3))
                .norm() < 1e-4);
    }
  }
}

}  // namespace
}  // namespace motiondb::tests::node_summary_test
