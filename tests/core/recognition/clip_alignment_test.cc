#include "core/recognition/clip_alignment.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "core/recognition/metric_observation.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::clip_alignment_test {
namespace {

// Two clips; the test uses the second.
core::MetricFrames Stored(const core::FrameMatrix& clip) {
  core::MetricFrames stored;
  core::FrameMatrix projected(3 + clip.rows(), clip.cols());
  projected << core::FrameMatrix::Constant(3, clip.cols(), 100), clip;
  stored.squared_norms = projected.rowwise().squaredNorm();
  stored.projected = core::SharedRows(std::move(projected));
  stored.rows.begin = {0, 3, static_cast<int>(stored.projected.rows())};
  for (int row = 0; row < stored.projected.rows(); ++row) stored.rows.frame.push_back(2 * row);
  return stored;
}

// Returns the sum of the probabilities of all paths from stored frame j at observed frame t.
double SumFrom(const core::FrameMatrix& observed, const core::FrameMatrix& clip, int t, int j) {
  if (j >= clip.rows()) return 0;
  const double here = std::exp(-(observed.row(t) - clip.row(j)).cast<double>().squaredNorm() / 6);
  if (t + 1 == observed.rows()) return here;
  return here *
         (0.2 * SumFrom(observed, clip, t + 1, j) + 0.6 * SumFrom(observed, clip, t + 1, j + 1) +
          0.2 * SumFrom(observed, clip, t + 1, j + 2));
}

}  // namespace

TEST_CASE("AlignToClip: equals the sum over all paths", "[core][recognition]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const core::FrameMatrix clip = WanderingStates(1 + static_cast<int>(seed % 9), 4, seed);
    const core::FrameMatrix observed =
        WanderingStates(1 + static_cast<int>(seed % 5), 4, seed + 50);
    const core::MetricFrames stored = Stored(clip);
    for (const bool anchored : {false, true}) {
      double sum = 0;
      for (int j = 0; j < clip.rows(); ++j) {
        sum += (anchored ? std::exp(-2.0 * j) : 1) * SumFrom(observed, clip, 0, j);
      }
      const auto alignment = core::AlignToClip(stored, stored.rows.of_clip(1), observed, anchored);
      CHECK(alignment.log_evidence == Approx(std::log(sum)).epsilon(1e-4).margin(1e-3));
      REQUIRE(alignment.nearest.size() == static_cast<std::size_t>(observed.rows()));
      for (int t = 0; t < observed.rows(); ++t) {
        Eigen::Index nearest = 0;
        const float minimum =
            (clip.rowwise() - observed.row(t)).rowwise().squaredNorm().minCoeff(&nearest);
        CHECK(alignment.nearest[t].frame == 2 * (3 + nearest));
        CHECK(alignment.nearest[t].squared_distance == Approx(minimum).epsilon(1e-3).margin(1e-3));
      }
    }
  }
}

TEST_CASE("AlignToClip: finite for long dissimilar observations", "[core][recognition]") {
  const core::FrameMatrix clip = WanderingStates(90, 8, 1);
  core::FrameMatrix observed = WanderingStates(300, 8, 2);
  observed.array() += 300;
  const core::MetricFrames stored = Stored(clip);
  const auto alignment = core::AlignToClip(stored, stored.rows.of_clip(1), observed, true);
  CHECK(std::isfinite(alignment.log_evidence));
  CHECK(alignment.log_evidence < -1e5);
}

TEST_CASE("AlignToClip: a motion fits its own clip and its own start best", "[core][recognition]") {
  const core::FrameMatrix clip = WanderingStates(60, 6, 1);
  const core::MetricFrames own = Stored(clip);
  const core::MetricFrames other = Stored(WanderingStates(60, 6, 2));
  CHECK(core::AlignToClip(own, own.rows.of_clip(1), clip, true).log_evidence >
        core::AlignToClip(other, other.rows.of_clip(1), clip, true).log_evidence);
  const core::FrameMatrix late = clip.bottomRows(20);
  CHECK(core::AlignToClip(own, own.rows.of_clip(1), late, false).log_evidence >
        core::AlignToClip(own, own.rows.of_clip(1), late, true).log_evidence + 10);
}

TEST_CASE("ComparedFrames: end with the newest", "[core][recognition]") {
  using Frames = std::vector<int>;
  CHECK(core::ComparedFrames(10, 5, 2, false) == Frames{10, 12, 14});
  CHECK(core::ComparedFrames(10, 6, 2, false) == Frames{11, 13, 15});
  CHECK(core::ComparedFrames(0, 24, 4, false) == Frames{3, 7, 11, 15, 19, 23});
  CHECK(core::ComparedFrames(0, 5, 2, true) == Frames{0, 2, 4});
  CHECK(core::ComparedFrames(0, 6, 2, true) == Frames{0, 2, 5});
  CHECK(core::ComparedFrames(0, 2, 2, true) == Frames{1});
  CHECK(core::ComparedFrames(7, 1, 4, true) == Frames{7});
  CHECK(core::ComparedFrames(7, 1, 4, false) == Frames{7});
}

namespace {

// Squared distances between observed frames (columns) and a clip's frames (rows).
Eigen::ArrayXXf Distances(int clip_frames, int frames, float scale, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, scale);
  Eigen::ArrayXXf distances(clip_frames, frames);
  for (Eigen::Index i = 0; i < distances.size(); ++i) distances.data()[i] = uniform(random);
  return distances;
}

}  // namespace

TEST_CASE("PathSum: sums from roots equal sums from distances, or are reported as inexact",
          "[core][recognition]") {
  int exact = 0;
  for (const float scale : {1.0F, 50.0F, 500.0F, 5000.0F, 1e6F}) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Eigen::ArrayXXf distances = Distances(40, 12, scale, seed);
      core::PathSum paths;
      paths.Begin(40, false);
      for (Eigen::Index t = 0; t < 12; ++t) paths.AddFrame(distances.col(t));
      const double expected = paths.LogEvidence();

      core::PathSum from_roots;
      from_roots.Begin(40, false);
      double nearest_sum = 0;
      Eigen::ArrayXf roots(40);
      for (Eigen::Index t = 0; t < 12; ++t) {
        const float nearest = distances.col(t).minCoeff();
        core::PathSum::Roots(distances.col(t), nearest, roots);
        from_roots.AddRoots(roots, nearest);
        nearest_sum += nearest;
      }
      CAPTURE(scale, seed);
      CHECK(expected <= core::PathSum::LogEvidenceBound(40, nearest_sum) + 1e-9);
      if (!from_roots.IsExact()) continue;
      ++exact;
      CHECK(from_roots.LogEvidence() == Approx(expected).epsilon(1e-6).margin(1e-4));
    }
  }
  CHECK(exact >= 40);  // of 100; for large distances only AddFrame is exact
  CHECK(exact < 100);
}

}  // namespace motiondb::tests::clip_alignment_test
