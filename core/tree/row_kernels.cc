#include "core/tree/row_kernels.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/tree/row_loops.h"
#include "core/tree/wide_vectors.h"

namespace motiondb::core {
namespace {

constexpr int kBlockRows = 16;  // of a few hundred dimensions: they stay in the first-level cache

const RowLoops& Loops() {
#if defined(__x86_64__)
  if (WideVectors()) return kAvx2RowLoops;
#endif
  return kPortableRowLoops;
}

// Calls body(rows, count) for blocks of rows.
template <typename Body>
void InBlocks(const float* rows, int count, int stride, const Body& body) {
  for (int begin = 0; begin < count; begin += kBlockRows) {
    body(rows + static_cast<std::ptrdiff_t>(begin) * stride, std::min(kBlockRows, count - begin));
  }
}

}  // namespace

void AddRows(const float* rows, int count, int dimensions, double* sum) {
  std::vector<float> sums(static_cast<std::size_t>(dimensions));
  InBlocks(rows, count, dimensions, [&](const float* block, int block_rows) {
    std::fill(sums.begin(), sums.end(), 0.0f);
    Loops().add(block, block_rows, dimensions, sums.data());
    for (int d = 0; d < dimensions; ++d) sum[d] += static_cast<double>(sums[d]);
  });
}

void CentreRows(const float* rows, int count, int dimensions, const float* mean, float* centred) {
  Loops().centre(rows, count, dimensions, PaddedDimensions(dimensions), mean, centred);
}

double AddScatterProduct(const float* rows, int count, int stride, int padded, const float* q,
                         float offset, double* product) {
  float dots[kBlockRows];
  double total = 0;
  const RowLoops& loops = Loops();
  InBlocks(rows, count, stride, [&](const float* block, int block_rows) {
    loops.dot(block, block_rows, stride, padded, q, kBlockRows, dots);
    for (int r = 0; r < block_rows; ++r) total += static_cast<double>(dots[r] -= offset);
    loops.add_multiples(block, block_rows, stride, padded, dots, product);
  });
  return total;
}

void ProjectRows(const float* rows, int count, int dimensions, const double* axis,
                 double* projections) {
  Loops().project(rows, count, dimensions, axis, projections);
}

void MultiplyRows(const float* rows, int count, int dimensions, const float* matrix, int columns,
                  float* product) {
  Loops().multiply(rows, count, dimensions, matrix, columns, product);
}

float ScaledSquares(const float* x, const float* mean, const float* factors, int dimensions) {
  return Loops().scaled_squares(x, mean, factors, dimensions);
}

}  // namespace motiondb::core
