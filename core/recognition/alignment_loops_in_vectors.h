// AlignmentLoops in vectors of kWidth numbers: for the files that compile it for one kind of
// processor (core/tree/vectors.h).
#pragma once

#include "core/recognition/alignment_loops.h"
#include "core/tree/vectors.h"

namespace motiondb::core {

template <int kWidth>
class AlignmentLoopsInVectors {
 public:
  static constexpr AlignmentLoops All() {
    return {Distances, DistancesOfOne, Least, Roots, Advance};
  }

 private:
  using V = Vectors<kWidth>;
  using Floats = typename V::Floats;
  using FloatHalf = typename V::FloatHalf;
  using Doubles = typename V::Doubles;
  static constexpr int kHalf = kWidth / 2;
  static constexpr int kRegisters = 12;  // of 16, for sums

  static void Distances(const float* rows, const float* squared_norms, int count, int dimensions,
                        const float* observed, const float* observed_norms, int frames,
                        float* squared, int stride) {
    if constexpr (kFrameLanes > 2 * kWidth) {
      if (frames > 3 * kWidth)
        return DistancesOf<4>(rows, squared_norms, count, dimensions, observed, observed_norms,
                              frames, squared, stride);
      if (frames > 2 * kWidth)
        return DistancesOf<3>(rows, squared_norms, count, dimensions, observed, observed_norms,
                              frames, squared, stride);
    }
    if (frames > kWidth)
      return DistancesOf<2>(rows, squared_norms, count, dimensions, observed, observed_norms,
                            frames, squared, stride);
    DistancesOf<1>(rows, squared_norms, count, dimensions, observed, observed_norms, frames,
                   squared, stride);
  }

  // Frames in kVectors vectors.
  template <int kVectors>
  static void DistancesOf(const float* rows, const float* squared_norms, int count, int dimensions,
                          const float* observed, const float* observed_norms, int frames,
                          float* squared, int stride) {
    constexpr int kRows = kRegisters / kVectors < 6 ? kRegisters / kVectors : 6;
    int r = 0;
    for (; r + kRows <= count; r += kRows) {
      DistancesOfRows<kVectors, kRows>(rows + r * dimensions, squared_norms + r, dimensions,
                                       observed, observed_norms, frames, squared + r, stride);
    }
    for (; r < count; ++r) {
      DistancesOfRows<kVectors, 1>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                                   observed_norms, frames, squared + r, stride);
    }
  }

  template <int kVectors, int kRows>
  static void DistancesOfRows(const float* rows, const float* squared_norms, int dimensions,
                              const float* observed, const float* observed_norms, int frames,
                              float* squared, int stride) {
    Floats lanes[kRows][kVectors];
#pragma GCC unroll 6
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) lanes[r][v] = Floats{};
    }
    for (int d = 0; d < dimensions; ++d) {
#pragma GCC unroll 6
      for (int r = 0; r < kRows; ++r) {
        const float factor = rows[r * dimensions + d];
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v)
          lanes[r][v] += V::Load(observed + d * kFrameLanes + v * kWidth) * factor;
      }
    }
    float of_rows[kRows][kFrameLanes];
#pragma GCC unroll 6
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        const Floats apart =
            (V::Load(observed_norms + v * kWidth) + squared_norms[r]) - 2.0F * lanes[r][v];
        V::Store(apart > 0.0F ? apart : Floats{}, &of_rows[r][v * kWidth]);
      }
    }
    for (int f = 0; f < frames; ++f) {
#pragma GCC unroll 6
      for (int r = 0; r < kRows; ++r) squared[f * stride + r] = of_rows[r][f];
    }
  }

  static void DistancesOfOne(const float* rows, const float* squared_norms, int count,
                             int dimensions, const float* observed, float observed_norm,
                             float* squared) {
    constexpr int kRows = 4;
    int r = 0;
    for (; r + kRows <= count; r += kRows) {
      DistancesOfOneTo<kRows>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                              observed_norm, squared + r);
    }
    for (; r < count; ++r) {
      DistancesOfOneTo<1>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                          observed_norm, squared + r);
    }
  }

  // Sums of every eighth number, put together in one way for every width.
  template <int kRows>
  static void DistancesOfOneTo(const float* rows, const float* squared_norms, int dimensions,
                               const float* observed, float observed_norm, float* squared) {
    constexpr int kVectors = 8 / kWidth;
    Floats lanes[kRows][kVectors];
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) lanes[r][v] = Floats{};
    }
    int d = 0;
    for (; d + 8 <= dimensions; d += 8) {
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) {
        const Floats factor = V::Load(observed + d + v * kWidth);
#pragma GCC unroll 4
        for (int r = 0; r < kRows; ++r)
          lanes[r][v] += V::Load(rows + r * dimensions + d + v * kWidth) * factor;
      }
    }
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
      typename Vectors<4>::Floats sums;
      if constexpr (kWidth == 4) {
        sums = lanes[r][0] + lanes[r][1];
      } else {
        sums = V::template SumOfHalves<typename Vectors<4>::Floats>(lanes[r][0]);
      }
      float product = (sums[0] + sums[1]) + (sums[2] + sums[3]);
      for (int i = d; i < dimensions; ++i) product += rows[r * dimensions + i] * observed[i];
      const float apart = (observed_norm + squared_norms[r]) - 2.0F * product;
      squared[r] = apart > 0.0F ? apart : 0.0F;
    }
  }

  static float Least(const float* numbers, int count) {
    float least = numbers[0];
    int i = 0;
    if (count >= kWidth) {
      Floats lanes = V::Load(numbers);
      for (i = kWidth; i + kWidth <= count; i += kWidth) {
        const Floats more = V::Load(numbers + i);
        lanes = more < lanes ? more : lanes;
      }
      for (int lane = 0; lane < kWidth; ++lane) least = lanes[lane] < least ? lanes[lane] : least;
    }
    for (; i < count; ++i) least = numbers[i] < least ? numbers[i] : least;
    return least;
  }

  static float Roots(const float* squared, int count, float nearest, float scale, float* roots) {
    Floats greatest = Floats{} + nearest;
    int i = 0;
    for (; i + kWidth <= count; i += kWidth) {
      const Floats here = V::Load(squared + i);
      greatest = here > greatest ? here : greatest;
      V::Store(Exp((nearest - here) * scale), roots + i);
    }
    float of_all = nearest;
    for (int lane = 0; lane < kWidth; ++lane)
      of_all = greatest[lane] > of_all ? greatest[lane] : of_all;
    if (i == count) return of_all;
    float rest[kWidth] = {};
    for (int k = 0; i + k < count; ++k) {
      rest[k] = (nearest - squared[i + k]) * scale;
      of_all = squared[i + k] > of_all ? squared[i + k] : of_all;
    }
    V::Store(Exp(V::Load(rest)), rest);
    for (int k = 0; i + k < count; ++k) roots[i + k] = rest[k];
    return of_all;
  }

  // exp(x) of -80 <= x <= 0, to two units in the last place; lower ones are -80. As 2^n exp(r),
  // |r| <= log(2) / 2, with the polynomial of Cephes' expf.
  static Floats Exp(Floats x) {
    constexpr float kLeast = -80;
    constexpr float kLog2High = 0.693359375F;  // their sum is log(2), the first times n is exact
    constexpr float kLog2Low = -2.12194440e-4F;
    const Floats least = Floats{} + kLeast;
    x = x > least ? x : least;
    // Towards zero, which is up.
    const auto n = __builtin_convertvector(x * 1.44269504F - 0.5F, typename V::Ints);
    const Floats whole = __builtin_convertvector(n, Floats);
    const Floats r = (x - whole * kLog2High) - whole * kLog2Low;
    Floats p = r * 1.9875691500e-4F + 1.3981999507e-3F;
    p = p * r + 8.3334519073e-3F;
    p = p * r + 4.1665795894e-2F;
    p = p * r + 1.6666665459e-1F;
    p = p * r + 5.0000001201e-1F;
    p = p * (r * r) + r + 1.0F;
    return p * reinterpret_cast<Floats>((n + 127) << 23);
  }

  // Sums of every fourth number, put together last: the same for every width.
  static double Advance(const double* ending, const float* roots, int count, double stay, double go,
                        double skip, double* next) {
    constexpr int kSums = 4 / kHalf;
    Doubles sums[kSums];
#pragma GCC unroll 2
    for (int s = 0; s < kSums; ++s) sums[s] = Doubles{};
    int z = 0;
    for (; z + 4 <= count; z += 4) {
#pragma GCC unroll 2
      for (int s = 0; s < kSums; ++s) {
        const int at = z + s * kHalf;
        Doubles density = V::Widened(V::LoadHalf(roots + at));
        density *= density;
        density *= density;
        const Doubles arriving = V::LoadDoubles(ending + at + 2) * stay +
                                 V::LoadDoubles(ending + at + 1) * go +
                                 V::LoadDoubles(ending + at) * skip;
        const Doubles here = arriving * density;
        V::Store(here, next + at);
        sums[s] += here;
      }
    }
    double lanes[4];
    for (int i = 0; i < 4; ++i) lanes[i] = sums[i / kHalf][i % kHalf];
    for (; z < count; ++z) {
      double density = roots[z];
      density *= density;
      density *= density;
      next[z] = (ending[z + 2] * stay + ending[z + 1] * go + ending[z] * skip) * density;
      lanes[z % 4] += next[z];
    }
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
  }
};

}  // namespace motiondb::core
