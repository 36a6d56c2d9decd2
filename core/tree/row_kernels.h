// Inner loops over rows of float32 numbers, frames x dimensions, for the tree build and for
// distances to node means. Bitwise identical on all processors (vectors.h).
#pragma once

#include "core/motion/matrix.h"

namespace motiondb::core {

// Rows are read in steps of kRowLanes numbers.
inline constexpr int kRowLanes = 16;

// Rounds dimensions up to whole steps.
constexpr int PaddedDimensions(int dimensions) {
  return (dimensions + kRowLanes - 1) / kRowLanes * kRowLanes;
}

// Adds `count` contiguous rows of `dimensions` numbers to `sum` (dimensions).
void AddRows(const float* rows, int count, int dimensions, double* sum);

// Writes rows minus `mean` (dimensions), each padded with zeros, to `centred` (count x padded).
void CentreRows(const float* rows, int count, int dimensions, const float* mean, float* centred);

// Adds the sum of s x over the rows x to `product` (padded), with s = q x - offset. With offset = q
// m, m being the rows' mean, this is S q, S being their scatter matrix. Returns the sum of s. Rows
// are `stride` numbers apart; `padded` numbers of each must be readable. q is padded with zeros;
// the padding of `product` is undefined. Products in single precision, sums over runs of rows in
// double: the error is about 1e-7 |q| times the sum of |x|^2.
double AddScatterProduct(const float* rows, int count, int stride, int padded, const float* q,
                         float offset, double* product);

// Writes the inner products of rows (count x dimensions) with `axis` (padded with zeros), in double
// precision.
void ProjectRows(const float* rows, int count, int dimensions, const double* axis,
                 double* projections);

// Writes rows (count x dimensions) times `matrix` (dimensions x columns) to `product` (count x
// columns), all row-major, in single precision. Each row's product is independent of the other
// rows.
void MultiplyRows(const float* rows, int count, int dimensions, const float* matrix, int columns,
                  float* product);

// Returns the sum of ((x - mean) factor)^2 over the dimensions, in single precision; NaN if x has a
// NaN.
float ScaledSquares(const float* x, const float* mean, const float* factors, int dimensions);

// Frames of a block: one for each vector lane.
inline constexpr int kSquaresLanes = 8;

// As above for many frames, with early termination. `frames`: `blocks` blocks of kSquaresLanes
// frames, each dimensions x kSquaresLanes. `squares` (blocks x kSquaresLanes) receives the sums, or
// infinity for a block in which every sum exceeds its limit in `limits` (blocks x kSquaresLanes).
// Returns the number of blocks with sums.
int ScaledSquaresWithin(const float* frames, int blocks, const float* mean, const float* factors,
                        int dimensions, const float* limits, float* squares);

// Returns whether ScaledSquares of every x with low <= x <= high (dimensions each) is greater than
// `limit`, by a lower bound that allows for rounding. Can be false although it is.
bool IsBoxBeyond(const float* low, const float* high, const float* mean, const float* factors,
                 int dimensions, float limit);

// Adds, for the values x of each dimension between two bounds: their number, the sum of
// (x - centre), and the sum of its square. `count` rows start `stride` values apart.
void AddWithin(const float* rows, int count, Eigen::Index stride, int dimensions, const float* low,
               const float* high, const double* centre, double* counts, double* sums,
               double* squares);

// Matrix products for few rows, faster than Eigen's, which is compiled for the baseline processor.

// Returns rows * matrix. REQUIRES: rows.cols() == matrix.rows().
inline FrameMatrix RowProduct(const FrameMatrix& rows, const FrameMatrix& matrix) {
  FrameMatrix product(rows.rows(), matrix.cols());
  MultiplyRows(rows.data(), static_cast<int>(rows.rows()), static_cast<int>(rows.cols()),
               matrix.data(), static_cast<int>(matrix.cols()), product.data());
  return product;
}

}  // namespace motiondb::core
