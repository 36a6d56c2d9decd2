#include "core/tree/row_kernels.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/motion/matrix.h"
#include "tests/support/fixed_numbers.h"

namespace motiondb::tests::row_kernels_test {
namespace {

// Rows with padding, so that whole steps can be read from the last row.
struct Rows {
  core::FrameMatrix all;
  int count;

  Rows(int rows, int dimensions)
      : all(core::FrameMatrix::Random(rows + core::kRowLanes, dimensions)), count(rows) {}
  Eigen::MatrixXd exact() const { return all.topRows(count).cast<double>(); }
  int dimensions() const { return static_cast<int>(all.cols()); }
};

}  // namespace

TEST_CASE("Row kernels: equal the same sums in double precision", "[core][tree]") {
  for (const int dimensions : {1, 3, 4, 15, 16, 17, 50, 204, 600}) {
    for (const int count : {1, 2, 7, 8, 31, 32, 33, 100}) {
      CAPTURE(dimensions, count);
      const Rows rows(count, dimensions);
      const Eigen::MatrixXd exact = rows.exact();
      const int padded = core::PaddedDimensions(dimensions);

      Eigen::VectorXd sum = Eigen::VectorXd::Ones(dimensions);  // the kernel adds to it
      core::AddRows(rows.all.data(), count, dimensions, sum.data());
      const Eigen::VectorXd exact_sum = exact.colwise().sum().transpose();
      CHECK((sum - exact_sum - Eigen::VectorXd::Ones(dimensions)).norm() <=
            1e-6 * exact.norm() + 1e-6);

      const Eigen::VectorXf mean = Eigen::VectorXf::Random(dimensions);
      core::FrameMatrix centred = core::FrameMatrix::Constant(count, padded, 9);
      core::CentreRows(rows.all.data(), count, dimensions, mean.data(), centred.data());
      CHECK(centred.leftCols(dimensions) == rows.all.topRows(count).rowwise() - mean.transpose());
      CHECK((centred.rightCols(padded - dimensions).array() == 0).all());

      Eigen::VectorXf q = Eigen::VectorXf::Zero(padded);
      q.head(dimensions).setRandom();
      const Eigen::VectorXd factors = (exact * q.head(dimensions).cast<double>()).array() - 0.25;
      Eigen::VectorXd product = Eigen::VectorXd::Ones(padded);
      const double total = core::AddScatterProduct(rows.all.data(), count, dimensions, padded,
                                                   q.data(), 0.25f, product.data());
      const double error = 1e-6 * exact.squaredNorm() * (1 + q.norm());
      CHECK(std::abs(total - factors.sum()) <= error);
      CHECK((product.head(dimensions) - exact.transpose() * factors -
             Eigen::VectorXd::Ones(dimensions))
                .norm() <= error);

      Eigen::VectorXd axis = Eigen::VectorXd::Zero(padded);
      axis.head(dimensions).setRandom();
      Eigen::VectorXd projections(count);
      core::ProjectRows(rows.all.data(), count, dimensions, axis.data(), projections.data());
      CHECK(projections.isApprox(exact * axis.head(dimensions), 1e-12));

      const Eigen::RowVectorXf x = Eigen::RowVectorXf::Random(dimensions);
      const double squares = core::ScaledSquares(x.data(), mean.data(), q.data(), dimensions);
      const Eigen::RowVectorXd apart =
          (x - mean.transpose())
              .cast<double>()
              .cwiseProduct(q.head(dimensions).cast<double>().transpose());
      CHECK(squares == Approx(apart.squaredNorm()).epsilon(1e-5).margin(1e-9));
    }
  }
}

// The release build uses the processor's widest vectors, sanitizer builds the baseline: both have
// the same digest.
TEST_CASE("Row kernels: the same bits on every processor", "[core][tree]") {
  BitDigest digest;
  for (const int dimensions : {1, 2, 3, 5, 7, 15, 16, 17, 31, 33, 50, 102, 203, 204, 205, 600}) {
    for (const int count : {1, 2, 3, 4, 5, 7, 15, 16, 17, 31, 33, 47, 100}) {
      const int padded = core::PaddedDimensions(dimensions);
      const core::FrameMatrix rows = FixedNumbers(count + core::kRowLanes, dimensions);
      const core::FrameMatrix q = FixedNumbers(1, padded);
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(dimensions);
      core::AddRows(rows.data(), count, dimensions, sum.data());
      core::FrameMatrix centred(count, padded);
      core::CentreRows(rows.data(), count, dimensions, q.data(), centred.data());
      Eigen::VectorXd product = Eigen::VectorXd::Zero(padded);
      digest.Add(core::AddScatterProduct(centred.data(), count, padded, padded, q.data(), 0.25f,
                                         product.data()));
      Eigen::VectorXd axis = Eigen::VectorXd::Zero(padded);
      axis.head(dimensions) = q.leftCols(dimensions).cast<double>().transpose();
      Eigen::VectorXd projections(count);
      core::ProjectRows(rows.data(), count, dimensions, axis.data(), projections.data());
      digest.AddAll(sum);
      digest.AddAll(centred);
      digest.AddAll(product);
      digest.AddAll(projections);
      digest.AddAll(core::RowProduct(rows, FixedNumbers(dimensions, 20)));
      digest.Add(core::ScaledSquares(rows.row(0).data(), rows.row(1).data(), rows.row(2).data(),
                                     dimensions));
      const core::FrameMatrix blocks = FixedNumbers(2 * dimensions, core::kSquaresLanes);
      Eigen::RowVectorXf squares(2 * core::kSquaresLanes);
      core::ScaledSquaresWithin(
          blocks.data(), 2, rows.row(1).data(), rows.row(2).data(), dimensions,
          Eigen::RowVectorXf::Constant(squares.size(), static_cast<float>(dimensions))
              .eval()
              .data(),
          squares.data());
      digest.AddAll(squares);
    }
  }
  CHECK(digest.value() == 0xc03538841c95083fU);
}

TEST_CASE("Row kernels: scaled squares within limits equal those of each frame", "[core][tree]") {
  constexpr int kBlocks = 3;
  constexpr int kFrames = kBlocks * core::kSquaresLanes;
  for (const int dimensions : {1, 11, 12, 13, 40, 204}) {
    const core::FrameMatrix frames = FixedNumbers(kFrames, dimensions);
    const core::FrameMatrix mean = FixedNumbers(1, dimensions);
    const core::FrameMatrix factors = 2 * core::FrameMatrix::Ones(1, dimensions);
    core::FrameMatrix blocks(kBlocks * dimensions, core::kSquaresLanes);
    for (int f = 0; f < kFrames; ++f) {
      blocks.block(f / core::kSquaresLanes * dimensions, f % core::kSquaresLanes, dimensions, 1) =
          frames.row(f).transpose();
    }
    // In the first block no frame is within its limit, in the second one frame, in the last all.
    Eigen::RowVectorXf limits = Eigen::RowVectorXf::Constant(kFrames, -1);
    limits[core::kSquaresLanes + 3] = limits.tail(core::kSquaresLanes).setConstant(1e9F)[0];
    Eigen::RowVectorXf squares(kFrames);
    CHECK(core::ScaledSquaresWithin(blocks.data(), kBlocks, mean.data(), factors.data(), dimensions,
                                    limits.data(), squares.data()) == 2);
    for (int f = 0; f < kFrames; ++f) {
      if (f < core::kSquaresLanes) {
        CHECK(std::isinf(squares[f]));
        continue;
      }
      CHECK(squares[f] == Approx(core::ScaledSquares(frames.row(f).data(), mean.data(),
                                                     factors.data(), dimensions))
                              .epsilon(1e-5)
                              .margin(1e-6));
    }
  }
}

TEST_CASE("Row product: equals the exact product, independent of neighbouring rows",
          "[core][tree]") {
  for (const int dimensions : {1, 3, 40, 204}) {
    for (const int columns : {1, 2, 3, 4, 7, 8, 12, 15, 16, 17, 31, 40, 63, 64, 65, 204}) {
      for (const int count : {1, 2, 3, 4, 5, 8, 13}) {
        CAPTURE(dimensions, columns, count);
        const core::FrameMatrix rows = core::FrameMatrix::Random(count, dimensions);
        const core::FrameMatrix matrix = core::FrameMatrix::Random(dimensions, columns);
        const core::FrameMatrix product = core::RowProduct(rows, matrix);
        const Eigen::MatrixXd exact = rows.cast<double>() * matrix.cast<double>();
        CHECK((product.cast<double>() - exact).cwiseAbs().maxCoeff() <= 1e-6 * dimensions);
        for (int r = 0; r < count; ++r)
          CHECK(core::RowProduct(rows.row(r), matrix) == product.row(r));
      }
    }
  }
}

TEST_CASE("Row kernels: a missing value makes the scaled squares NaN", "[core][tree]") {
  for (const int dimensions : {1, 7, 16, 27, 204}) {
    const Eigen::RowVectorXf ones = Eigen::RowVectorXf::Ones(dimensions);
    for (int d = 0; d < dimensions; ++d) {
      Eigen::RowVectorXf x = 3 * ones;
      CHECK(core::ScaledSquares(x.data(), ones.data(), ones.data(), dimensions) ==
            4.0f * static_cast<float>(dimensions));
      x[d] = std::nanf("");
      CHECK(std::isnan(core::ScaledSquares(x.data(), ones.data(), ones.data(), dimensions)));
    }
  }
}

TEST_CASE("Row kernels: equal rows have equal projections at every position", "[core][tree]") {
  const int dimensions = 21;
  core::FrameMatrix rows = core::FrameMatrix::Random(50, dimensions);
  rows.rowwise() = rows.row(0).eval();
  Eigen::VectorXd axis = Eigen::VectorXd::Zero(core::PaddedDimensions(dimensions));
  axis.head(dimensions).setRandom();
  Eigen::VectorXd projections(50);
  core::ProjectRows(rows.data(), 50, dimensions, axis.data(), projections.data());
  CHECK((projections.array() == projections[0]).all());
}

}  // namespace motiondb::tests::row_kernels_test
