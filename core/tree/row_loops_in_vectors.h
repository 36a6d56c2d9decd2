// RowLoops in vectors of kWidth numbers: for the files that compile it for one kind of processor.
// Those may be compiled for more than every processor has, so nothing here calls a function that
// another file could share (an inline one of the standard library, say).
#pragma once

#include "core/tree/row_kernels.h"
#include "core/tree/row_loops.h"

namespace motiondb::core {

template <int kWidth>
struct RowVectors;

template <>
struct RowVectors<4> {
  typedef float Floats __attribute__((vector_size(16)));
  typedef float FloatHalf __attribute__((vector_size(8)));
  typedef double Doubles __attribute__((vector_size(16)));
};

template <>
struct RowVectors<8> {
  typedef float Floats __attribute__((vector_size(32)));
  typedef float FloatHalf __attribute__((vector_size(16)));
  typedef double Doubles __attribute__((vector_size(32)));
};

template <int kWidth>
class RowLoopsInVectors {
 public:
  static constexpr RowLoops All() { return {Add, Centre, Dot, AddMultiples, Project}; }

 private:
  static constexpr int kHalf = kWidth / 2;
  static constexpr int kVectors = kRowLanes / kWidth;  // in a step
  static constexpr int kTogether = 8;                  // rows that are added at a time
  // Rows whose products are taken at a time: as many as 16 registers hold the lanes of.
  static constexpr int kDots = kWidth / 2;

  using Floats = typename RowVectors<kWidth>::Floats;
  using FloatHalf = typename RowVectors<kWidth>::FloatHalf;
  using Doubles = typename RowVectors<kWidth>::Doubles;  // of half the width
  using Fours = RowVectors<4>::Floats;
  using Twos = RowVectors<4>::Doubles;

  // Vectors are loaded from and stored to any address.
  template <typename V = Floats, typename T>
  static V Load(const T* from) {
    static_assert(sizeof(V{}[0]) == sizeof(T));
    V v;
    __builtin_memcpy(&v, from, sizeof(V));
    return v;
  }

  template <typename V, typename T>
  static void Store(V v, T* to) {
    static_assert(sizeof(v[0]) == sizeof(T));
    __builtin_memcpy(to, &v, sizeof(V));
  }

  // Up to half a vector, then zeros.
  static FloatHalf LoadFew(const float* from, int count) {
    if (count >= kHalf) return Load<FloatHalf>(from);
    FloatHalf few = {};
    for (int i = 0; i < count; ++i) few[i] = from[i];
    return few;
  }

  static Doubles Widened(FloatHalf v) { return __builtin_convertvector(v, Doubles); }

  // The first half of a vector (0) or the second (1).
  template <typename Half, typename V>
  static Half HalfOf(const V& v, int i) {
    static_assert(2 * sizeof(Half) == sizeof(V));
    Half half;
    __builtin_memcpy(&half, reinterpret_cast<const char*>(&v) + i * sizeof(Half), sizeof(Half));
    return half;
  }

  template <typename Half, typename V>
  static Half SumOfHalves(const V& v) {
    return HalfOf<Half>(v, 0) + HalfOf<Half>(v, 1);
  }

  // Sums of a step's lanes, put together in the same way for every width: lanes of vectors of four
  // (of two in double precision) side by side, then what is in the vector.
  static float SumOfLanes(const Floats (&lanes)[kVectors]) {
    Fours sum;
    if constexpr (kWidth == 4) {
      sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    } else {
      sum = SumOfHalves<Fours>(lanes[0]) + SumOfHalves<Fours>(lanes[1]);
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }

  static double SumOfLanes(const Doubles (&lanes)[2 * kVectors]) {
    Twos sum;
    if constexpr (kWidth == 4) {
      sum = ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
            ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
    } else {
      sum = (SumOfHalves<Twos>(lanes[0]) + SumOfHalves<Twos>(lanes[1])) +
            (SumOfHalves<Twos>(lanes[2]) + SumOfHalves<Twos>(lanes[3]));
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
      Floats sum = Load(sums + d);
#pragma GCC unroll 8
      for (int r = 0; r < kRows; ++r) sum += Load(rows + r * dimensions + d);
      Store(sum, sums + d);
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
        Store(Load(rows + d) - Load(mean + d), centred + d);
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
        const Floats factor = Load(q + d + v * kWidth);
#pragma GCC unroll 4
        for (int r = 0; r < kRows; ++r)
          lanes[r][v] += Load(rows + r * stride + d + v * kWidth) * factor;
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
          lanes[v] += Load(rows + r * stride + d + v * kWidth) * factors[r];
      }
#pragma GCC unroll 8
      for (int h = 0; h < 2 * kVectors; ++h) {
        double* const to = sums + d + h * kHalf;
        Store(Load<Doubles>(to) + Widened(HalfOf<FloatHalf>(lanes[h / 2], h % 2)), to);
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
          lanes[v] += Widened(Load<FloatHalf>(rows + at)) * Load<Doubles>(axis + at);
        }
      }
#pragma GCC unroll 8
      for (int v = 0; v < 2 * kVectors; ++v) {
        const int at = whole + v * kHalf;
        if (at >= dimensions) break;
        lanes[v] += Widened(LoadFew(rows + at, dimensions - at)) * Load<Doubles>(axis + at);
      }
      projections[r] = SumOfLanes(lanes);
    }
  }
};

}  // namespace motiondb::core
