#include "core/tree/row_kernels.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/tree/vectors.h"

namespace motiondb::core {
namespace {

constexpr int kBlockRows = 16;                 // with some hundred dimensions they fit the L1 cache
constexpr int kVectors = kRowLanes / kFloats;  // vectors in a step
constexpr int kRowsAtOnce = 8;                 // rows added at a time
constexpr int kDots = 4;  // rows of a product at a time: 16 registers hold their lanes

// Calls body(rows, count) for blocks of rows.
template <typename Body>
void InBlocks(const float* rows, int count, int stride, const Body& body) {
  for (int begin = 0; begin < count; begin += kBlockRows) {
    body(rows + static_cast<std::ptrdiff_t>(begin) * stride, std::min(kBlockRows, count - begin));
  }
}

template <int kRows>
void AddFew(const float* rows, int dimensions, float* sums) {
  int d = 0;
  for (; d + kFloats <= dimensions; d += kFloats) {
    Floats sum = Load(sums + d);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) sum += Load(rows + r * dimensions + d);
    Store(sum, sums + d);
  }
  for (; d < dimensions; ++d) {
    for (int r = 0; r < kRows; ++r) sums[d] += rows[r * dimensions + d];
  }
}

// sums (dimensions) += each row, in order.
MOTIONDB_WIDEST_VECTORS
void Add(const float* rows, int count, int dimensions, float* sums) {
  int r = 0;
  for (; r + kRowsAtOnce <= count; r += kRowsAtOnce)
    AddFew<kRowsAtOnce>(rows + r * dimensions, dimensions, sums);
  for (; r < count; ++r) AddFew<1>(rows + r * dimensions, dimensions, sums);
}

template <int kRows>
void DotFew(const float* rows, int stride, int padded, const float* q, float* dots) {
  Floats lanes[kRows][kVectors];  // cleared element by element, to stay in registers
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) lanes[r][v] = Floats{};
  }
  for (int d = 0; d < padded; d += kRowLanes) {
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) __builtin_prefetch(rows + (r + kBlockRows) * stride + d);
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      const Floats factor = Load(q + d + v * kFloats);
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r)
        lanes[r][v] += Load(rows + r * stride + d + v * kFloats) * factor;
    }
  }
  for (int r = 0; r < kRows; ++r)
    dots[r] = SumOf(SumOfHalves(lanes[r][0]) + SumOfHalves(lanes[r][1]));
}

// dots (count): inner products with q (padded), in single precision. Prefetches the next block.
MOTIONDB_WIDEST_VECTORS
void Dot(const float* rows, int count, int stride, int padded, const float* q, float* dots) {
  int r = 0;
  for (; r + kDots <= count; r += kDots)
    DotFew<kDots>(rows + r * stride, stride, padded, q, dots + r);
  for (; r < count; ++r) DotFew<1>(rows + r * stride, stride, padded, q, dots + r);
}

// sums (padded) += sum of factors[r] * row r, in order, in single precision: for few rows.
MOTIONDB_WIDEST_VECTORS
void AddMultiples(const float* rows, int count, int stride, int padded, const float* factors,
                  double* sums) {
  for (int d = 0; d < padded; d += kRowLanes) {
    Floats lanes[kVectors] = {};
#pragma GCC unroll 4
    for (int r = 0; r < count; ++r) {
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v)
        lanes[v] += Load(rows + r * stride + d + v * kFloats) * factors[r];
    }
#pragma GCC unroll 4
    for (int h = 0; h < 2 * kVectors; ++h) {
      double* const to = sums + d + h * kDoubles;
      Store(Load(to) + Widened(HalfOf<FloatHalf>(lanes[h / 2], h % 2)), to);
    }
  }
}

template <typename V, int kRows, int kWide>
void MultiplyBlock(const float* rows, int dimensions, const float* matrix, int columns,
                   float* product) {
  constexpr int kStep = sizeof(V) / sizeof(float);
  V sums[kRows][kWide];
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kWide; ++v) sums[r][v] = V{};
  }
  for (int d = 0; d < dimensions; ++d) {
#pragma GCC unroll 8
    for (int v = 0; v < kWide; ++v) {
      const V factors = LoadAs<V>(matrix + d * columns + v * kStep);
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r) sums[r][v] += factors * rows[r * dimensions + d];
    }
  }
  for (int r = 0; r < kRows; ++r) {
    for (int v = 0; v < kWide; ++v) Store(sums[r][v], product + r * columns + v * kStep);
  }
}

template <int kRows, int kWide>
void MultiplyFew(const float* rows, int dimensions, const float* matrix, int columns,
                 float* product) {
  int c = 0;
  for (; c + kWide * kFloats <= columns; c += kWide * kFloats)
    MultiplyBlock<Floats, kRows, kWide>(rows, dimensions, matrix + c, columns, product + c);
  for (; c + kFloats <= columns; c += kFloats)
    MultiplyBlock<Floats, kRows, 1>(rows, dimensions, matrix + c, columns, product + c);
  for (; c + kDoubles <= columns; c += kDoubles)
    MultiplyBlock<FloatHalf, kRows, 1>(rows, dimensions, matrix + c, columns, product + c);
  for (; c < columns; ++c) {
    for (int r = 0; r < kRows; ++r) {
      float sum = 0;
      for (int d = 0; d < dimensions; ++d)
        sum += rows[r * dimensions + d] * matrix[d * columns + c];
      product[r * columns + c] = sum;
    }
  }
}

}  // namespace

void AddRows(const float* rows, int count, int dimensions, double* sum) {
  std::vector<float> sums(static_cast<std::size_t>(dimensions));
  InBlocks(rows, count, dimensions, [&](const float* block, int block_rows) {
    std::fill(sums.begin(), sums.end(), 0.0f);
    Add(block, block_rows, dimensions, sums.data());
    for (int d = 0; d < dimensions; ++d) sum[d] += static_cast<double>(sums[d]);
  });
}

MOTIONDB_WIDEST_VECTORS
void CentreRows(const float* rows, int count, int dimensions, const float* mean, float* centred) {
  const int padded = PaddedDimensions(dimensions);
  for (int r = 0; r < count; ++r, rows += dimensions, centred += padded) {
    int d = 0;
    for (; d + kFloats <= dimensions; d += kFloats)
      Store(Load(rows + d) - Load(mean + d), centred + d);
    for (; d < dimensions; ++d) centred[d] = rows[d] - mean[d];
    for (; d < padded; ++d) centred[d] = 0;
  }
}

double AddScatterProduct(const float* rows, int count, int stride, int padded, const float* q,
                         float offset, double* product) {
  float dots[kBlockRows];
  double total = 0;
  InBlocks(rows, count, stride, [&](const float* block, int block_rows) {
    Dot(block, block_rows, stride, padded, q, dots);
    for (int r = 0; r < block_rows; ++r) total += static_cast<double>(dots[r] -= offset);
    AddMultiples(block, block_rows, stride, padded, dots, product);
  });
  return total;
}

MOTIONDB_WIDEST_VECTORS
void ProjectRows(const float* rows, int count, int dimensions, const double* axis,
                 double* projections) {
  const int whole = dimensions / kRowLanes * kRowLanes;
  for (int r = 0; r < count; ++r, rows += dimensions) {
    Doubles lanes[2 * kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < 2 * kVectors; ++v) lanes[v] = Doubles{};
    for (int d = 0; d < whole; d += kRowLanes) {
#pragma GCC unroll 4
      for (int v = 0; v < 2 * kVectors; ++v) {
        const int at = d + v * kDoubles;
        lanes[v] += Widened(LoadHalf(rows + at)) * Load(axis + at);
      }
    }
#pragma GCC unroll 4
    for (int v = 0; v < 2 * kVectors; ++v) {
      const int at = whole + v * kDoubles;
      if (at >= dimensions) break;
      lanes[v] += Widened(LoadFew(rows + at, dimensions - at)) * Load(axis + at);
    }
    const DoubleHalf sum = (SumOfHalves(lanes[0]) + SumOfHalves(lanes[1])) +
                           (SumOfHalves(lanes[2]) + SumOfHalves(lanes[3]));
    projections[r] = sum[0] + sum[1];
  }
}

MOTIONDB_WIDEST_VECTORS
void MultiplyRows(const float* rows, int count, int dimensions, const float* matrix, int columns,
                  float* product) {
  // Block sizes by the number of registers.
  int r = 0;
  for (; r + 4 <= count; r += 4)
    MultiplyFew<4, 2>(rows + r * dimensions, dimensions, matrix, columns, product + r * columns);
  for (; r < count; ++r)
    MultiplyFew<1, 8>(rows + r * dimensions, dimensions, matrix, columns, product + r * columns);
}

MOTIONDB_WIDEST_VECTORS
float ScaledSquares(const float* x, const float* mean, const float* factors, int dimensions) {
  const int whole = dimensions / kRowLanes * kRowLanes;
  Floats lanes[kVectors];
#pragma GCC unroll 2
  for (int v = 0; v < kVectors; ++v) lanes[v] = Floats{};
  for (int d = 0; d < whole; d += kRowLanes) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      const int at = d + v * kFloats;
      const Floats z = (Load(x + at) - Load(mean + at)) * Load(factors + at);
      lanes[v] += z * z;
    }
  }
  // The rest is less than a step: four numbers at a time.
  FloatHalf sums[2 * kVectors];
#pragma GCC unroll 4
  for (int h = 0; h < 2 * kVectors; ++h) {
    sums[h] = HalfOf<FloatHalf>(lanes[h / 2], h % 2);
    const int at = whole + h * kDoubles;
    if (at >= dimensions) continue;
    const int few = dimensions - at;
    const FloatHalf z =
        (LoadFew(x + at, few) - LoadFew(mean + at, few)) * LoadFew(factors + at, few);
    sums[h] += z * z;
  }
  return SumOf((sums[0] + sums[1]) + (sums[2] + sums[3]));
}

MOTIONDB_WIDEST_VECTORS
int ScaledSquaresWithin(const float* frames, int blocks, const float* mean, const float* factors,
                        int dimensions, const float* limits, float* squares) {
  static_assert(kSquaresLanes == kFloats);
  constexpr int kDimensionsBetweenChecks = 12;  // dimensions between checks
  const Floats infinity = Floats{} + __builtin_inff();
  int within = 0;
  for (int b = 0; b < blocks; ++b) {
    const Floats limit = Load(limits + b * kFloats);
    const float* x = frames + b * dimensions * kFloats;
    Floats sums = {};
    bool is_beyond = false;
    for (int d = 0; d < dimensions && !is_beyond;) {
      const int end =
          d + kDimensionsBetweenChecks < dimensions ? d + kDimensionsBetweenChecks : dimensions;
      for (; d < end; ++d, x += kFloats) {
        const Floats z = (Load(x) - mean[d]) * factors[d];
        sums += z * z;
      }
      const Ints below = sums <= limit;
      int any = 0;
#pragma GCC unroll 8
      for (int lane = 0; lane < kFloats; ++lane) any |= below[lane];
      is_beyond = any == 0;
    }
    within += is_beyond ? 0 : 1;
    Store(is_beyond ? infinity : sums, squares + b * kFloats);
  }
  return within;
}

MOTIONDB_WIDEST_VECTORS
bool IsBoxBeyond(const float* least, const float* most, const float* mean, const float* factors,
                 int dimensions, float limit) {
  constexpr float kRounding = 1 - 1e-4F;  // far more than the sums differ by
  constexpr int kFirstLook = 4;           // vectors; then after twice as many, and so on
  Floats sums = {};
  int d = 0;
  int look = kFirstLook * kFloats;
  for (; d + kFloats <= dimensions; d += kFloats) {
    if (d == look) {
      if (SumOf(SumOfHalves(sums)) * kRounding > limit) return true;
      look *= 2;
    }
    const Floats at = Load(mean + d);
    const Floats below = Load(least + d) - at;
    const Floats above = at - Load(most + d);
    Floats apart = below > above ? below : above;
    apart = apart > 0.0F ? apart : Floats{};
    apart *= Load(factors + d);
    sums += apart * apart;
  }
  float sum = SumOf(SumOfHalves(sums));
  for (; d < dimensions; ++d) {
    const float below = least[d] - mean[d];
    const float above = mean[d] - most[d];
    float apart = below > above ? below : above;
    apart = apart > 0 ? apart * factors[d] : 0;
    sum += apart * apart;
  }
  return sum * kRounding > limit;
}

MOTIONDB_WIDEST_VECTORS
void AddWithin(const float* rows, int count, Eigen::Index stride, int dimensions,
               const float* least, const float* most, const double* centre, double* counts,
               double* sums, double* squares) {
  for (int r = 0; r < count; ++r, rows += stride) {
    int d = 0;
    for (; d + kDoubles <= dimensions; d += kDoubles) {
      const Doubles x = Widened(LoadHalf(rows + d));
      const Doubles one = Doubles{} + 1.0;
      Doubles counted = x >= Widened(LoadHalf(least + d)) ? one : Doubles{};
      counted = x <= Widened(LoadHalf(most + d)) ? counted : Doubles{};
      const Doubles apart = (x - Load(centre + d)) * counted;
      Store(Load(counts + d) + counted, counts + d);
      Store(Load(sums + d) + apart, sums + d);
      Store(Load(squares + d) + apart * apart, squares + d);
    }
    for (; d < dimensions; ++d) {
      if (!(rows[d] >= least[d] && rows[d] <= most[d])) continue;
      const double apart = rows[d] - centre[d];
      counts[d] += 1;
      sums[d] += apart;
      squares[d] += apart * apart;
    }
  }
}

}  // namespace motiondb::core
