// The loops under row_kernels.h, compiled once for every processor and once for those that have
// wider vectors. All give the same bits: each number of a sum is added to by the same numbers in
// the same order, in vectors that hold more of them at a time, and no product is fused with a sum.
// Safe to call from any thread.
#pragma once

namespace motiondb::core {

// Rows (`count` of them) start `stride` numbers apart, or `dimensions` where there is no stride.
// `padded` is a multiple of kRowLanes (row_kernels.h), and so many numbers can be read from each.
struct RowLoops {
  // sums (dimensions) += each row, one after the other.
  void (*add)(const float* rows, int count, int dimensions, float* sums);
  // centred (count x padded): rows minus `mean` (dimensions), then zeros.
  void (*centre)(const float* rows, int count, int dimensions, int padded, const float* mean,
                 float* centred);
  // dots (count): inner products with q (padded), in single precision. Asks for the rows
  // `ask_ahead` further on meanwhile.
  void (*dot)(const float* rows, int count, int stride, int padded, const float* q, int ask_ahead,
              float* dots);
  // sums (padded) += the sum of the rows, each times its factor (count), which is taken in single
  // precision, one after the other: for few rows.
  void (*add_multiples)(const float* rows, int count, int stride, int padded, const float* factors,
                        double* sums);
  // projections (count): inner products with `axis` (padded with zeros), in double precision.
  void (*project)(const float* rows, int count, int dimensions, const double* axis,
                  double* projections);
  // product (count x columns): rows times `matrix` (dimensions x columns, row after row); each
  // number is summed over the dimensions one after the other.
  void (*multiply)(const float* rows, int count, int dimensions, const float* matrix, int columns,
                   float* product);
  // The sum of ((x - mean) factor)^2 over the dimensions, in single precision; NaN where x has one.
  float (*scaled_squares)(const float* x, const float* mean, const float* factors, int dimensions);
};

extern const RowLoops kPortableRowLoops;
#if defined(__x86_64__)
extern const RowLoops kAvx2RowLoops;  // only where WideVectors()
#endif

}  // namespace motiondb::core
