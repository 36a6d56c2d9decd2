// RowLoops in vectors of kWidth numbers: for the files that compile it for one kind of processor
// (vectors.h).
#pragma once

#include "core/tree/row_kernels.h"
#include "core/tree/row_loops.h"
#include "core/tree/vectors.h"

namespace motiondb::core {

template <int kWidth>
class RowLoopsInVectors {
 public:
  static constexpr RowLoops All() {
    return {Add, Centre, Dot, AddMultiples, Project, Multiply, ScaledSquares};
  }

 private:
  static constexpr int kHalf = kWidth / 2;
  static constexpr int kVectors = kRowLanes / kWidth;  // in a step
  static constexpr int kTogether = 8;                  // rows that are added at a time
  // Rows whose products are taken at a time: as many as 16 registers hold the lanes of.
  static constexpr int kDots = kWidth / 2;

  using V = Vectors<kWidth>;
  using Floats = typename V::Floats;
  using FloatHalf = typename V::FloatHalf;
  using Doubles = typename V::Doubles;
  using Fours = Vectors<4>::Floats;
  using Twos = Vectors<4>::Doubles;

  // Sums of a step's lanes, put together in the same way for every width: lanes of vectors of four
  // (of two in double precision) side by side, then what is in the vector.
  static float SumOfLanes(const Floats (&lanes)[kVectors]) {
    Fours sum;
    if constexpr (kWidth == 4) {
      sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    } else {
      sum = V::template SumOfHalves<Fours>(lanes[0]) + V::template SumOfHalves<Fours>(lanes[1]);
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }

  static double SumOfLanes(const Doubles (&lanes)[2 * kVectors]) {
    Twos sum;
    if constexpr (kWidth == 4) {
      sum = ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
            ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
    } else {
      sum = (V::template SumOfHalves<Twos>(lanes[0]) + V::template SumOfHalves<Twos>(lanes[1])) +
            (V::template SumOfHalves<Twos>(lanes[2]) + V::template SumOfHalves<Twos>(lanes[3]));
    }
    return sum[0] + sum[1];
  }

  static void Add(const float* rows, int count, int dimensions, float* sums) {
    int r = 0;
    for (; r + kTogether <= count; r += kTogether)
      AddFew<kTogether>(rows + r * dimensions, dimensions, sums);
    for (; r < count; ++r) AddFew<1>(rows + r * dimensions, dimensions, sums);
  }

  template <int kRows>
  static void AddFew(const float* rows, int dimensions, float* sums) {
    int d = 0;
    for (; d + kWidth <= dimensions; d += kWidth) {
      Floats sum = V::Load(sums + d);
#pragma GCC unroll 8
      for (int r = 0; r < kRows; ++r) sum += V::Load(rows + r * dimensions + d);
      V::Store(sum, sums + d);
    }
    for (; d < dimensions; ++d) {
      for (int r = 0; r < kRows; ++r) sums[d] += rows[r * dimensions + d];
    }
  }

  static void Centre(const float* rows, int count, int dimensions, int padded, const float* mean,
                     float* centred) {
    for (int r = 0; r < count; ++r, rows += dimensions, centred += padded) {
      int d = 0;
      for (; d + kWidth <= dimensions; d += kWidth)
        V::Store(V::Load(rows + d) - V::Load(mean + d), centred + d);
      for (; d < dimensions; ++d) centred[d] = rows[d] - mean[d];
      for (; d < padded; ++d) centred[d] = 0;
    }
  }

  static void Dot(const float* rows, int count, int stride, int padded, const float* q,
                  int ask_ahead, float* dots) {
    int r = 0;
    for (; r + kDots <= count; r += kDots)
      DotFew<kDots>(rows + r * stride, stride, padded, q, ask_ahead, dots + r);
    for (; r < count; ++r) DotFew<1>(rows + r * stride, stride, padded, q, ask_ahead, dots + r);
  }

  template <int kRows>
  static void DotFew(const float* rows, int stride, int padded, const float* q, int ask_ahead,
                     float* dots) {
    Floats lanes[kRows][kVectors];  // cleared one by one: an array would be cleared in memory
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) lanes[r][v] = Floats{};
    }
    for (int d = 0; d < padded; d += kRowLanes) {
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r) __builtin_prefetch(rows + (r + ask_ahead) * stride + d);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        const Floats factor = V::Load(q + d + v * kWidth);
#pragma GCC unroll 4
        for (int r = 0; r < kRows; ++r)
          lanes[r][v] += V::Load(rows + r * stride + d + v * kWidth) * factor;
      }
    }
    for (int r = 0; r < kRows; ++r) dots[r] = SumOfLanes(lanes[r]);
  }

  static void AddMultiples(const float* rows, int count, int stride, int padded,
                           const float* factors, double* sums) {
    for (int d = 0; d < padded; d += kRowLanes) {
      Floats lanes[kVectors] = {};
#pragma GCC unroll 4
      for (int r = 0; r < count; ++r) {
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v)
          lanes[v] += V::Load(rows + r * stride + d + v * kWidth) * factors[r];
      }
#pragma GCC unroll 8
      for (int h = 0; h < 2 * kVectors; ++h) {
        double* const to = sums + d + h * kHalf;
        V::Store(
            V::LoadDoubles(to) + V::Widened(V::template HalfOf<FloatHalf>(lanes[h / 2], h % 2)),
            to);
      }
    }
  }

  static void Project(const float* rows, int count, int dimensions, const double* axis,
                      double* projections) {
    const int whole = dimensions / kRowLanes * kRowLanes;
    for (int r = 0; r < count; ++r, rows += dimensions) {
      Doubles lanes[2 * kVectors];
#pragma GCC unroll 8
      for (int v = 0; v < 2 * kVectors; ++v) lanes[v] = Doubles{};
      for (int d = 0; d < whole; d += kRowLanes) {
#pragma GCC unroll 8
        for (int v = 0; v < 2 * kVectors; ++v) {
          const int at = d + v * kHalf;
          lanes[v] += V::Widened(V::LoadHalf(rows + at)) * V::LoadDoubles(axis + at);
        }
      }
#pragma GCC unroll 8
      for (int v = 0; v < 2 * kVectors; ++v) {
        const int at = whole + v * kHalf;
        if (at >= dimensions) break;
        lanes[v] += V::Widened(V::LoadFew(rows + at, dimensions - at)) * V::LoadDoubles(axis + at);
      }
      projections[r] = SumOfLanes(lanes);
    }
  }

  // Sums of a few rows times a few vectors of columns, as many as the registers hold.
  static void Multiply(const float* rows, int count, int dimensions, const float* matrix,
                       int columns, float* product) {
    int r = 0;
    for (; r + 4 <= count; r += 4)
      MultiplyFew<4, 2>(rows + r * dimensions, dimensions, matrix, columns, product + r * columns);
    for (; r < count; ++r)
      MultiplyFew<1, 8>(rows + r * dimensions, dimensions, matrix, columns, product + r * columns);
  }

  template <int kRows, int kWide>
  static void MultiplyFew(const float* rows, int dimensions, const float* matrix, int columns,
                          float* product) {
    int c = 0;
    for (; c + kWide * kWidth <= columns; c += kWide * kWidth)
      MultiplyBlock<V, kRows, kWide>(rows, dimensions, matrix + c, columns, product + c);
    for (; c + kWidth <= columns; c += kWidth)
      MultiplyBlock<V, kRows, 1>(rows, dimensions, matrix + c, columns, product + c);
    for (; c + 4 <= columns; c += 4)
      MultiplyBlock<Vectors<4>, kRows, 1>(rows, dimensions, matrix + c, columns, product + c);
    for (; c < columns; ++c) {
      for (int r = 0; r < kRows; ++r) {
        float sum = 0;
        for (int d = 0; d < dimensions; ++d)
          sum += rows[r * dimensions + d] * matrix[d * columns + c];
        product[r * columns + c] = sum;
      }
    }
  }

  template <typename Wide, int kRows, int kWide>
  static void MultiplyBlock(const float* rows, int dimensions, const float* matrix, int columns,
                            float* product) {
    constexpr int kStep = 2 * Wide::kHalf;
    typename Wide::Floats sums[kRows][kWide];
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
      for (int v = 0; v < kWide; ++v) sums[r][v] = typename Wide::Floats{};
    }
    for (int d = 0; d < dimensions; ++d) {
#pragma GCC unroll 8
      for (int v = 0; v < kWide; ++v) {
        const auto factors = Wide::Load(matrix + d * columns + v * kStep);
#pragma GCC unroll 4
        for (int r = 0; r < kRows; ++r) sums[r][v] += factors * rows[r * dimensions + d];
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int v = 0; v < kWide; ++v) Wide::Store(sums[r][v], product + r * columns + v * kStep);
    }
  }

  static float ScaledSquares(const float* x, const float* mean, const float* factors,
                             int dimensions) {
    const int whole = dimensions / kRowLanes * kRowLanes;
    Floats lanes[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) lanes[v] = Floats{};
    for (int d = 0; d < whole; d += kRowLanes) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        const int at = d + v * kWidth;
        const Floats z = (V::Load(x + at) - V::Load(mean + at)) * V::Load(factors + at);
        lanes[v] += z * z;
      }
    }
    // What is left is less than a step: four numbers at a time.
    Fours sums[kRowLanes / 4];
#pragma GCC unroll 4
    for (int f = 0; f < kRowLanes / 4; ++f) {
      if constexpr (kWidth == 4) {
        sums[f] = lanes[f];
      } else {
        sums[f] = V::template HalfOf<Fours>(lanes[f / 2], f % 2);
      }
      const int at = whole + 4 * f;
      if (at >= dimensions) continue;
      const int few = dimensions - at;
      const Fours z =
          (LoadFours(x + at, few) - LoadFours(mean + at, few)) * LoadFours(factors + at, few);
      sums[f] += z * z;
    }
    const Fours sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }

  // Up to four, then zeros.
  static Fours LoadFours(const float* from, int count) {
    if (count >= 4) return Vectors<4>::Load(from);
    Fours few = {from[0]};
    if (count > 1) few[1] = from[1];
    if (count > 2) few[2] = from[2];
    return few;
  }
};

}  // namespace motiondb::core
