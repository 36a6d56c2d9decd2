#include "core/recognition/alignment_loops.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/motion/matrix.h"
#include "tests/support/fixed_numbers.h"

namespace motiondb::tests::alignment_loops_test {
namespace {

// Inputs of the loops: rows of a clip, and observed frames in lanes.
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
        rows(FixedNumbers(count, dimensions)),
        observed(core::FrameMatrix::Zero(dimensions, core::kFrameLanes)) {
    observed.leftCols(frames) = FixedNumbers(dimensions + 1, frames).bottomRows(dimensions);
  }
};

struct Results {
  core::FrameMatrix squared;  // frames x count
  Eigen::RowVectorXf squared_of_one;
  float minimum = 0;
  float maximum = 0;
  Eigen::ArrayXf roots;
  Eigen::ArrayXd next;
  double sum = 0;
};

// Returns the squared norms of rows, summed in double precision, independent of the order.
Eigen::VectorXf SquaredNorms(const core::FrameMatrix& rows) {
  return rows.cast<double>().rowwise().squaredNorm().cast<float>();
}

Results Run(const Case& inputs, float scale) {
  const Eigen::VectorXf norms = SquaredNorms(inputs.rows);
  const Eigen::VectorXf observed_norms = SquaredNorms(inputs.observed.transpose());
  const Eigen::VectorXf one = inputs.observed.col(0);
  Results results;
  results.squared.resize(inputs.frames, inputs.count);
  core::SquaredDistances(inputs.rows.data(), norms.data(), inputs.count, inputs.dimensions,
                         inputs.observed.data(), observed_norms.data(), inputs.frames,
                         results.squared.data(), inputs.count);
  results.squared_of_one.resize(inputs.count);
  core::SquaredDistancesOfOne(inputs.rows.data(), norms.data(), inputs.count, inputs.dimensions,
                              one.data(), observed_norms[0], results.squared_of_one.data());
  results.minimum = core::Minimum(results.squared.data(), inputs.count);
  results.roots.resize(inputs.count);
  results.maximum = core::Roots(results.squared.data(), inputs.count, results.minimum, scale,
                                results.roots.data());
  const Eigen::ArrayXd ending = Eigen::ArrayXd::LinSpaced(inputs.count + 2, 0.1, 1);
  results.next.resize(inputs.count);
  results.sum = core::Advance(ending.data(), results.roots.data(), inputs.count, 0.2, 0.6, 0.2,
                              results.next.data());
  return results;
}

}  // namespace

// For both instruction sets, as in row_kernels_test.cc.
TEST_CASE("Alignment loops: bitwise identical on all processors", "[core][recognition]") {
  BitDigest digest;
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 9, 12, 13, 31, 250}) {
    for (const int dimensions : {1, 2, 7, 8, 9, 39, 40}) {
      for (const int frames : {1, 2, 4, 5, 8, 9, 12, 13, 16}) {
        const Results results = Run(Case(count, dimensions, frames), 0.04F);
        digest.AddAll(results.squared);
        digest.AddAll(results.squared_of_one);
        digest.AddAll(results.roots);
        digest.AddAll(results.next);
        for (const double number : {1.0 * results.minimum, 1.0 * results.maximum, results.sum})
          digest.Add(number);
      }
    }
  }
  CHECK(digest.value() == 0x2cb10c0058930b03U);
}

TEST_CASE("Alignment loops: equal scalar loops", "[core][recognition]") {
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 9, 12, 13, 31, 250}) {
    for (const int dimensions : {1, 2, 7, 8, 9, 39, 40}) {
      for (const int frames : {1, 2, 4, 5, 8, 9, 12, 13, 16}) {
        CAPTURE(count, dimensions, frames);
        const Case inputs(count, dimensions, frames);
        const float scale = frames % 2 == 0 ? 0.04F : 40.0F;  // 40 raises roots to exp(-80)
        const Results results = Run(inputs, scale);

        for (int f = 0; f < frames; ++f) {
          const Eigen::RowVectorXf expected =
              (inputs.rows.rowwise() - inputs.observed.col(f).transpose()).rowwise().squaredNorm();
          CHECK((results.squared.row(f) - expected).cwiseAbs().maxCoeff() < 1e-4F);
          if (f == 0) CHECK((results.squared_of_one - expected).cwiseAbs().maxCoeff() < 1e-4F);
        }
        const auto distances = results.squared.row(0).array();
        CHECK(results.minimum == distances.minCoeff());
        CHECK(results.maximum == distances.maxCoeff());
        double sum = 0;
        for (int z = 0; z < count; ++z) {
          const double exponent = (static_cast<double>(results.minimum) - distances[z]) * scale;
          CHECK(results.roots[z] == Approx(std::exp(std::max(-80.0, exponent))).epsilon(2e-5));
          const double step = 0.9 / (count + 1);
          const double arriving = 0.1 + step * (z + 1);
          CHECK(
              results.next[z] ==
              Approx(arriving * std::pow(static_cast<double>(results.roots[z]), 4)).epsilon(1e-9));
          sum += results.next[z];
        }
        CHECK(results.sum == Approx(sum).epsilon(1e-12));
      }
    }
  }
}

}  // namespace motiondb::tests::alignment_loops_test
