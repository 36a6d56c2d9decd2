#include "core/tree/node_gaussians.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/tree/feature_scale.h"
#include "core/tree/tree_builder.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::node_gaussians_test {

TEST_CASE("NodeGaussians: mean and shrunk variance of each node's frames", "[core][tree]") {
  const core::FrameMatrix states = WanderingStates(400, 6, 2);
  const auto tree = core::BuildTree(states, 8, core::RunSerially);
  REQUIRE(tree.ok());
  const auto gaussians = core::NodeGaussians::Fit(*tree, states, core::RunSerially);
  const Eigen::MatrixXd all = states.cast<double>();
  const Eigen::RowVectorXd var_all =
      (all.rowwise() - all.colwise().mean()).cwiseAbs2().colwise().mean();
  for (std::size_t b = 0; b < tree->branches().size(); ++b) {
    const core::Branch& branch = tree->branches()[b];
    const int n = branch.end - branch.begin;
    Eigen::MatrixXd frames(n, states.cols());
    for (int i = 0; i < n; ++i) frames.row(i) = all.row(tree->frame_order()[branch.begin + i]);
    const Eigen::RowVectorXd mean = frames.colwise().mean();
    const Eigen::RowVectorXd var = (frames.rowwise() - mean).cwiseAbs2().colwise().mean();
    const double l = 16.0 / (n + 16.0);
    for (Eigen::Index d = 0; d < states.cols(); ++d) {
      CHECK(gaussians.means()(b, d) == Approx(mean[d]).margin(1e-5));
      CHECK(gaussians.variances()(b, d) ==
            Approx(std::max((1 - l) * var[d] + l * 0.3 * var_all[d], 1e-3 * var_all.mean())));
    }
  }
}

TEST_CASE("NodeGaussians: log density is the Gaussian's, without missing dimensions",
          "[core][tree]") {
  const core::FrameMatrix means = core::FrameMatrix::Random(3, 7);
  const core::FrameMatrix variances = core::FrameMatrix::Random(3, 7).cwiseAbs().array() + 0.1f;
  const auto gaussians = core::NodeGaussians::Create(means, variances);
  REQUIRE(gaussians.ok());
  core::FrameMatrix x = core::FrameMatrix::Random(1, 7);
  for (const int missing : {0, 1, 3, 7}) {
    for (int d = 0; d < missing; ++d) x(0, d) = std::nanf("");
    for (int b = 0; b < 3; ++b) {
      double expected = 0;
      for (int d = missing; d < 7; ++d) {
        const double difference = x(0, d) - means(b, d);
        expected -= 0.5 * (difference * difference / variances(b, d) +
                           std::log(2 * std::numbers::pi * variances(b, d)));
      }
      CHECK(gaussians->LogDensity(b, x.data()) == Approx(expected).margin(1e-5));
    }
  }
}

TEST_CASE("NodeGaussians: refuses variances that are not positive and finite", "[core][tree]") {
  const core::FrameMatrix means = core::FrameMatrix::Zero(2, 3);
  core::FrameMatrix variances = core::FrameMatrix::Ones(2, 3);
  for (const float bad : {0.0f, -1.0f, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    variances(1, 2) = bad;
    CHECK_FALSE(core::NodeGaussians::Create(means, variances).ok());
  }
  CHECK_FALSE(core::NodeGaussians::Create(means, core::FrameMatrix::Ones(3, 3)).ok());
}

TEST_CASE("FeatureScale: kinds are scaled to a pooled deviation of 1, and back", "[core][tree]") {
  core::FrameMatrix states = WanderingStates(500, 12, 9);
  for (Eigen::Index d = 0; d < 12; ++d) {
    if (d % 6 >= 3) states.col(d) *= 40;
  }
  const core::FrameMatrix original = states;
  const auto variances = [](const core::FrameMatrix& m) -> Eigen::RowVectorXf {
    return (m.rowwise() - m.colwise().mean()).cwiseAbs2().colwise().mean();
  };
  const auto scale = core::MakeFeatureScale(core::Scaling::kKind, states);
  scale.Apply(states);
  double pooled[2] = {0, 0};
  const Eigen::RowVectorXf by_kind = variances(states);
  for (Eigen::Index d = 0; d < 12; ++d) pooled[d % 6 >= 3] += by_kind[d] / 6;
  CHECK(pooled[0] == Approx(1).epsilon(1e-4));
  CHECK(pooled[1] == Approx(1).epsilon(1e-4));
  scale.Revert(states);
  CHECK(states.isApprox(original, 1e-5f));

  core::MakeFeatureScale(core::Scaling::kDimension, states).Apply(states);
  CHECK(variances(states).isApprox(Eigen::RowVectorXf::Ones(12), 1e-3f));
  CHECK(core::MakeFeatureScale(core::Scaling::kNone, states).divisor ==
        Eigen::RowVectorXf::Ones(12));
  CHECK(core::MakeFeatureScale(core::Scaling::kKind, core::FrameMatrix::Ones(4, 12)).divisor ==
        Eigen::RowVectorXf::Ones(12));
}

TEST_CASE("FeatureScale: a few corrupt frames do not change it", "[core][tree]") {
  for (const int frames : {500, 20000}) {
    const core::FrameMatrix states = WanderingStates(frames, 12, 9);
    core::FrameMatrix corrupt = states;
    for (int f = 7; f < frames; f += frames / 4) corrupt.row(f).array() += 100;
    corrupt.row(frames / 2).array() -= 1e6F;
    for (const auto scaling : {core::Scaling::kKind, core::Scaling::kDimension}) {
      const auto clean = core::MakeFeatureScale(scaling, states);
      CHECK(core::MakeFeatureScale(scaling, corrupt).divisor.isApprox(clean.divisor, 0.01F));
    }
    // Without the corrupt frames it is the plain deviation.
    const Eigen::RowVectorXd plain =
        (states.cast<double>().rowwise() - states.cast<double>().colwise().mean())
            .cwiseAbs2()
            .colwise()
            .mean();
    CHECK(core::RobustVariances(states).isApprox(plain, 1e-9));
  }
}

}  // namespace motiondb::tests::node_gaussians_test
