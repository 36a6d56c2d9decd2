#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/recognition/clip_alignment.h"

namespace motiondb::tests::path_sum_test {
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

}  // namespace motiondb::tests::path_sum_test
