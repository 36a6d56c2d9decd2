// The inner loops over rows of float32 numbers, frames x dimensions: those of the tree build over
// the rows of a node, and the distance of one row from a node's mean. The same bits on every
// processor (vectors.h). Safe to call from any thread.
#pragma once

#include "core/motion/matrix.h"

namespace motiondb::core {

// Rows are read in steps of this many numbers.
inline constexpr int kRowLanes = 16;

// Dimensions of a row, rounded up to whole steps.
constexpr int PaddedDimensions(int dimensions) {
  return (dimensions + kRowLanes - 1) / kRowLanes * kRowLanes;
}

// Adds `count` rows (each of `dimensions` numbers, one after the other) to `sum` (dimensions).
void AddRows(const float* rows, int count, int dimensions, double* sum);

// Writes rows minus `mean` (dimensions), each padded with zeros, to `centred` (count x padded).
void CentreRows(const float* rows, int count, int dimensions, const float* mean, float* centred);

// Adds the sum of s x over the rows x to `product` (padded), s = q x - offset: with offset = q m, m
// being the rows' mean, S q, S being their scatter matrix. Rows start `stride` numbers apart, and
// `padded` numbers can be read from each; q is padded with zeros, and the numbers of `product`
// behind the dimensions mean nothing. Returns the sum of s. Products are taken in single precision,
// runs of rows summed in double: the error is about 1e-7 |q| times the sum of |x|^2.
double AddScatterProduct(const float* rows, int count, int stride, int padded, const float* q,
                         float offset, double* product);

// Inner products of rows (count x dimensions) with `axis` (padded with zeros), in double precision.
void ProjectRows(const float* rows, int count, int dimensions, const double* axis,
                 double* projections);

// Writes rows (count x dimensions) times `matrix` (dimensions x columns), both row after row, to
// `product` (count x columns), in single precision. A row's product does not depend on the rows
// beside it.
void MultiplyRows(const float* rows, int count, int dimensions, const float* matrix, int columns,
                  float* product);

// The sum of ((x - mean) factor)^2 over the dimensions, in single precision; NaN where x has one.
float ScaledSquares(const float* x, const float* mean, const float* factors, int dimensions);

// Frames that are compared at a time: one a lane.
inline constexpr int kSquaresLanes = 8;

// The same of many frames, given up early. `frames` has `blocks` blocks of kSquaresLanes frames,
// each dimensions x kSquaresLanes. squares (blocks x kSquaresLanes): the sum of a frame, or
// infinity where those of all frames of the block are greater than their limits (blocks x
// kSquaresLanes). Returns the number of blocks that have sums.
int ScaledSquaresWithin(const float* frames, int blocks, const float* mean, const float* factors,
                        int dimensions, const float* limits, float* squares);

// Whether ScaledSquares of every x with least <= x <= most (dimensions each) is greater than
// `limit`, by a lower bound that allows for rounding. May be false though it is.
bool IsBoxBeyond(const float* least, const float* most, const float* mean, const float* factors,
                 int dimensions, float limit);

// Adds, for the numbers x of each dimension that are between two bounds: how many there are, the
// sum of (x - centre), and the sum of its square. `count` rows start `stride` numbers apart.
void AddWithin(const float* rows, int count, Eigen::Index stride, int dimensions,
               const float* least, const float* most, const double* centre, double* counts,
               double* sums, double* squares);

// Products of a few rows with a matrix, faster than Eigen's, which knows no processor newer than
// the oldest. Pure; safe to call from any thread.

// rows * matrix. REQUIRES: rows.cols() == matrix.rows().
inline FrameMatrix RowProduct(const FrameMatrix& rows, const FrameMatrix& matrix) {
  FrameMatrix product(rows.rows(), matrix.cols());
  MultiplyRows(rows.data(), static_cast<int>(rows.rows()), static_cast<int>(rows.cols()),
               matrix.data(), static_cast<int>(matrix.cols()), product.data());
  return product;
}

}  // namespace motiondb::core
