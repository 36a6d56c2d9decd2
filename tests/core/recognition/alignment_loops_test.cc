#include "core/recognition/alignment_loops.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/wide_vectors.h"

namespace motiondb::tests {
namespace {

// A clip's rows, observed frames in lanes, and what the loops make of them.
struct Case {
  int count;
  int dimensions;
  int frames;
  core::FrameMatrix rows;
  core::FrameMatrix observed;

  Case(int rows_count, int dims, int frame_count)
      : count(rows_count),
        dimensions(dims),
        frames(frame_count),
        rows(core::FrameMatrix::Random(count, dimensions)),
        observed(core::FrameMatrix::Zero(dimensions, core::kFrameLanes)) {
    observed.leftCols(frames).setRandom();
  }
};

struct Results {
  core::FrameMatrix squared;  // frames x count
  Eigen::RowVectorXf squared_of_one;
  float least = 0;
  float greatest = 0;
  Eigen::ArrayXf roots;
  Eigen::ArrayXd next;
  double sum = 0;

  bool operator==(const Results& other) const {
    return squared == other.squared && squared_of_one == other.squared_of_one &&
           least == other.least && greatest == other.greatest && (roots == other.roots).all() &&
           (next == other.next).all() && sum == other.sum;
  }
};

Results Run(const Case& of, float scale) {
  const core::AlignmentLoops& loops = core::LoopsOfAlignment();
  const Eigen::VectorXf norms = of.rows.rowwise().squaredNorm();
  const Eigen::RowVectorXf observed_norms = of.observed.colwise().squaredNorm();
  const Eigen::VectorXf one = of.observed.col(0);
  Results results;
  results.squared.resize(of.frames, of.count);
  loops.distances(of.rows.data(), norms.data(), of.count, of.dimensions, of.observed.data(),
                  observed_norms.data(), of.frames, results.squared.data(), of.count);
  results.squared_of_one.resize(of.count);
  loops.distances_of_one(of.rows.data(), norms.data(), of.count, of.dimensions, one.data(),
                         observed_norms[0], results.squared_of_one.data());
  results.least = loops.least(results.squared.data(), of.count);
  results.roots.resize(of.count);
  results.greatest =
      loops.roots(results.squared.data(), of.count, results.least, scale, results.roots.data());
  const Eigen::ArrayXd ending = Eigen::ArrayXd::LinSpaced(of.count + 2, 0.1, 1);
  results.next.resize(of.count);
  results.sum = loops.advance(ending.data(), results.roots.data(), of.count, 0.2, 0.6, 0.2,
                              results.next.data());
  return results;
}

struct WideAgain {
  ~WideAgain() { core::UseWideVectors(true); }
};

}  // namespace

TEST_CASE("Alignment loops: what they say, the same bits in vectors of any width",
          "[core][recognition]") {
  const WideAgain again;
  if (!core::UseWideVectors(true)) WARN("this processor has no wider vectors than every one");
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 9, 12, 13, 31, 250}) {
    for (const int dimensions : {1, 2, 7, 8, 9, 39, 40}) {
      for (const int frames : {1, 2, 4, 5, 8, 9, 12, 13, 16}) {
        CAPTURE(count, dimensions, frames);
        const Case of(count, dimensions, frames);
        const float scale = frames % 2 == 0 ? 0.04F : 40.0F;  // the latter cuts off
        core::UseWideVectors(true);
        const Results wide = Run(of, scale);
        core::UseWideVectors(false);
        CHECK(Run(of, scale) == wide);

        for (int f = 0; f < frames; ++f) {
          const Eigen::RowVectorXf expected =
              (of.rows.rowwise() - of.observed.col(f).transpose()).rowwise().squaredNorm();
          CHECK((wide.squared.row(f) - expected).cwiseAbs().maxCoeff() < 1e-4F);
          if (f == 0) CHECK((wide.squared_of_one - expected).cwiseAbs().maxCoeff() < 1e-4F);
        }
        const auto distances = wide.squared.row(0).array();
        CHECK(wide.least == distances.minCoeff());
        CHECK(wide.greatest == distances.maxCoeff());
        double sum = 0;
        for (int z = 0; z < count; ++z) {
          const double exponent = (static_cast<double>(wide.least) - distances[z]) * scale;
          CHECK(wide.roots[z] == Approx(std::exp(std::max(-80.0, exponent))).epsilon(2e-5));
          const double step = 0.9 / (count + 1);
          const double arriving = 0.1 + step * (z + 1);
          CHECK(wide.next[z] ==
                Approx(arriving * std::pow(static_cast<double>(wide.roots[z]), 4)).epsilon(1e-9));
          sum += wide.next[z];
        }
        CHECK(wide.sum == Approx(sum).epsilon(1e-12));
      }
    }
  }
}

}  // namespace motiondb::tests
