#include "core/recognition/alignment_loops.h"

#include "core/tree/vectors.h"

namespace motiondb::core {
namespace {

template <int kVectors, int kRows>
void DistancesOfRows(const float* rows, const float* squared_norms, int dimensions,
                     const float* observed, const float* observed_norms, int frames, float* squared,
                     int stride) {
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
        lanes[r][v] += Load(observed + d * kFrameLanes + v * kFloats) * factor;
    }
  }
  float of_rows[kRows][kFrameLanes];
#pragma GCC unroll 6
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const Floats distance =
          (Load(observed_norms + v * kFloats) + squared_norms[r]) - 2.0F * lanes[r][v];
      Store(distance > 0.0F ? distance : Floats{}, &of_rows[r][v * kFloats]);
    }
  }
  for (int f = 0; f < frames; ++f) {
#pragma GCC unroll 6
    for (int r = 0; r < kRows; ++r) squared[f * stride + r] = of_rows[r][f];
  }
}

// As SquaredDistances, for frames that fit in kVectors vectors.
template <int kVectors>
void DistancesOf(const float* rows, const float* squared_norms, int count, int dimensions,
                 const float* observed, const float* observed_norms, int frames, float* squared,
                 int stride) {
  constexpr int kRows = 6;  // the sums use 12 of 16 registers
  int r = 0;
  for (; r + kRows <= count; r += kRows) {
    DistancesOfRows<kVectors, kRows>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                                     observed_norms, frames, squared + r, stride);
  }
  for (; r < count; ++r) {
    DistancesOfRows<kVectors, 1>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                                 observed_norms, frames, squared + r, stride);
  }
}

// As SquaredDistancesOfOne, for kRows rows. Each lane sums every eighth product.
template <int kRows>
void DistancesOfOneFrame(const float* rows, const float* squared_norms, int dimensions,
                         const float* observed, float observed_norm, float* squared) {
  Floats lanes[kRows];
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) lanes[r] = Floats{};
  int d = 0;
  for (; d + kFloats <= dimensions; d += kFloats) {
    const Floats factor = Load(observed + d);
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) lanes[r] += Load(rows + r * dimensions + d) * factor;
  }
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
    float product = SumOf(SumOfHalves(lanes[r]));
    for (int i = d; i < dimensions; ++i) product += rows[r * dimensions + i] * observed[i];
    const float distance = (observed_norm + squared_norms[r]) - 2.0F * product;
    squared[r] = distance > 0.0F ? distance : 0.0F;
  }
}

// Returns exp(max(x, -80)) for x <= 0, with an error of at most two units in the last place.
// Computes 2^n exp(r) with |r| <= log(2) / 2; exp(r) is the polynomial of Cephes' expf.
Floats Exp(Floats x) {
  constexpr float kMinX = -80;
  constexpr float kLog2High = 0.693359375F;  // high + low = log(2); n * high is exact
  constexpr float kLog2Low = -2.12194440e-4F;
  const Floats min_x = Floats{} + kMinX;
  x = x > min_x ? x : min_x;
  // The conversion rounds towards zero: up, because the number is negative.
  const auto n = __builtin_convertvector(x * 1.44269504F - 0.5F, Ints);
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

}  // namespace

MOTIONDB_WIDEST_VECTORS
void SquaredDistances(const float* rows, const float* squared_norms, int count, int dimensions,
                      const float* observed, const float* observed_norms, int frames,
                      float* squared, int stride) {
  static_assert(kFrameLanes == 2 * kFloats);
  if (frames > kFloats) {
    DistancesOf<2>(rows, squared_norms, count, dimensions, observed, observed_norms, frames,
                   squared, stride);
  } else {
    DistancesOf<1>(rows, squared_norms, count, dimensions, observed, observed_norms, frames,
                   squared, stride);
  }
}

MOTIONDB_WIDEST_VECTORS
void SquaredDistancesOfOne(const float* rows, const float* squared_norms, int count, int dimensions,
                           const float* observed, float observed_norm, float* squared) {
  constexpr int kRows = 4;
  int r = 0;
  for (; r + kRows <= count; r += kRows) {
    DistancesOfOneFrame<kRows>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                               observed_norm, squared + r);
  }
  for (; r < count; ++r) {
    DistancesOfOneFrame<1>(rows + r * dimensions, squared_norms + r, dimensions, observed,
                           observed_norm, squared + r);
  }
}

MOTIONDB_WIDEST_VECTORS
float Minimum(const float* numbers, int count) {
  float minimum = numbers[0];
  int i = 0;
  if (count >= kFloats) {
    Floats lanes = Load(numbers);
    for (i = kFloats; i + kFloats <= count; i += kFloats) {
      const Floats more = Load(numbers + i);
      lanes = more < lanes ? more : lanes;
    }
    for (int lane = 0; lane < kFloats; ++lane)
      minimum = lanes[lane] < minimum ? lanes[lane] : minimum;
  }
  for (; i < count; ++i) minimum = numbers[i] < minimum ? numbers[i] : minimum;
  return minimum;
}

MOTIONDB_WIDEST_VECTORS
float Roots(const float* squared, int count, float nearest, float scale, float* roots) {
  Floats maxima = Floats{} + nearest;
  int i = 0;
  for (; i + kFloats <= count; i += kFloats) {
    const Floats here = Load(squared + i);
    maxima = here > maxima ? here : maxima;
    Store(Exp((nearest - here) * scale), roots + i);
  }
  float maximum = nearest;
  for (int lane = 0; lane < kFloats; ++lane)
    maximum = maxima[lane] > maximum ? maxima[lane] : maximum;
  if (i == count) return maximum;
  float rest[kFloats] = {};
  for (int k = 0; i + k < count; ++k) {
    rest[k] = (nearest - squared[i + k]) * scale;
    maximum = squared[i + k] > maximum ? squared[i + k] : maximum;
  }
  Store(Exp(Load(rest)), rest);
  for (int k = 0; i + k < count; ++k) roots[i + k] = rest[k];
  return maximum;
}

MOTIONDB_WIDEST_VECTORS
double Advance(const double* ending, const float* roots, int count, double stay, double go,
               double skip, double* next) {
  Doubles sums = {};  // one sum per lane; added at the end
  int z = 0;
  for (; z + kDoubles <= count; z += kDoubles) {
    Doubles density = Widened(LoadHalf(roots + z));
    density *= density;
    density *= density;
    const Doubles arriving =
        Load(ending + z + 2) * stay + Load(ending + z + 1) * go + Load(ending + z) * skip;
    const Doubles here = arriving * density;
    Store(here, next + z);
    sums += here;
  }
  double lanes[kDoubles];
  for (int i = 0; i < kDoubles; ++i) lanes[i] = sums[i];
  for (; z < count; ++z) {
    double density = roots[z];
    density *= density;
    density *= density;
    next[z] = (ending[z + 2] * stay + ending[z + 1] * go + ending[z] * skip) * density;
    lanes[z % kDoubles] += next[z];
  }
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

namespace {

constexpr int kWarpedSteps[] = {2, 0};  // to stay and to skip, as places before the row

}  // namespace

MOTIONDB_WIDEST_VECTORS
void ExtendCheapest(const float* cost, const int* start, const float* squared, int count,
                    float warp, float* next_cost, int* next_start) {
  int z = 0;
  for (; z + kFloats <= count; z += kFloats) {
    Floats least = Load(cost + z + 1);
    Ints from = LoadAs<Ints>(start + z + 1);
    for (const int other : kWarpedSteps) {
      const Floats warped = Load(cost + z + other) + warp;
      const Ints is_less = warped < least;
      least = is_less ? warped : least;
      from = is_less ? LoadAs<Ints>(start + z + other) : from;
    }
    Store(least + Load(squared + z), next_cost + z);
    Store(from, next_start + z);
  }
  for (; z < count; ++z) {
    int from = 1;
    float least = cost[z + 1];
    for (const int other : kWarpedSteps) {
      const float warped = cost[z + other] + warp;
      if (!(warped < least)) continue;
      least = warped;
      from = other;
    }
    next_cost[z] = least + squared[z];
    next_start[z] = start[z + from];
  }
}

}  // namespace motiondb::core
