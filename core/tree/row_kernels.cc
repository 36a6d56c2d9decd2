#include "core/tree/row_kernels.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

namespace motiondb::core {
namespace {

constexpr int kBlockRows = 32;  // of a few hundred dimensions: they stay in the first-level cache
constexpr int kTogether = 8;    // rows that are added at a time
constexpr int kWidth = 4;
constexpr int kVectors = kRowLanes / kWidth;

typedef float Floats __attribute__((vector_size(kWidth * sizeof(float))));
typedef float FloatPair __attribute__((vector_size(kWidth / 2 * sizeof(float))));
typedef double Doubles __attribute__((vector_size(kWidth / 2 * sizeof(double))));

// Vectors are loaded from and stored to any address.
template <typename V = Floats, typename T>
V Load(const T* from) {
  static_assert(sizeof(V{}[0]) == sizeof(T));
  V v;
  std::memcpy(&v, from, sizeof(V));
  return v;
}

template <typename V, typename T>
void Store(V v, T* to) {
  static_assert(sizeof(v[0]) == sizeof(T));
  std::memcpy(to, &v, sizeof(V));
}

// Calls body(rows, count) for blocks of rows.
template <typename Body>
void InBlocks(const float* rows, int count, int stride, const Body& body) {
  for (int begin = 0; begin < count; begin += kBlockRows) {
    body(rows + static_cast<std::ptrdiff_t>(begin) * stride, std::min(kBlockRows, count - begin));
  }
}

// sums (dimensions) += kRows rows, one after the other.
template <int kRows>
void AddFewRows(const float* rows, int dimensions, float* sums) {
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

// Inner products of kRows rows with q (padded), in single precision; the rows a block further on
// are asked for meanwhile.
template <int kRows>
void DotRows(const float* rows, int stride, int padded, const float* q, float* dots) {
  Floats lanes[kRows][kVectors] = {};
  for (int d = 0; d < padded; d += kRowLanes) {
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) __builtin_prefetch(rows + (r + kBlockRows) * stride + d);
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const Floats factor = Load(q + d + v * kWidth);
#pragma GCC unroll 4
      for (int r = 0; r < kRows; ++r)
        lanes[r][v] += Load(rows + r * stride + d + v * kWidth) * factor;
    }
  }
  for (int r = 0; r < kRows; ++r) {
    const Floats sum = (lanes[r][0] + lanes[r][1]) + (lanes[r][2] + lanes[r][3]);
    dots[r] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

// sums (padded) += kRows rows, each times its factor, one after the other.
template <int kRows>
void AddMultiples(const float* rows, int stride, int padded, const float* factors, float* sums) {
  for (int d = 0; d < padded; d += kWidth) {
    Floats sum = Load(sums + d);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) sum += Load(rows + r * stride + d) * factors[r];
    Store(sum, sums + d);
  }
}

// Adds kRowLanes numbers times factors to the lanes, in double precision.
void AddProducts(const float* numbers, const double* factors, Doubles* lanes) {
#pragma GCC unroll 8
  for (int v = 0; v < 2 * kVectors; ++v) {
    const auto wide = __builtin_convertvector(Load<FloatPair>(numbers + 2 * v), Doubles);
    lanes[v] += wide * Load<Doubles>(factors + 2 * v);
  }
}

}  // namespace

void AddRows(const float* rows, int count, int dimensions, double* sum) {
  std::vector<float> sums(static_cast<std::size_t>(dimensions));
  InBlocks(rows, count, dimensions, [&](const float* block, int block_rows) {
    std::fill(sums.begin(), sums.end(), 0.0f);
    int r = 0;
    for (; r + kTogether <= block_rows; r += kTogether) {
      AddFewRows<kTogether>(block + r * dimensions, dimensions, sums.data());
    }
    for (; r < block_rows; ++r) AddFewRows<1>(block + r * dimensions, dimensions, sums.data());
    for (int d = 0; d < dimensions; ++d) sum[d] += static_cast<double>(sums[d]);
  });
}

void CentreRows(const float* rows, int count, int dimensions, const float* mean, float* centred) {
  const int padded = PaddedDimensions(dimensions);
  for (int r = 0; r < count; ++r, rows += dimensions, centred += padded) {
    int d = 0;
    for (; d + kWidth <= dimensions; d += kWidth)
      Store(Load(rows + d) - Load(mean + d), centred + d);
    for (; d < dimensions; ++d) centred[d] = rows[d] - mean[d];
    for (; d < padded; ++d) centred[d] = 0;
  }
}

double AddScatterProduct(const float* rows, int count, int stride, int padded, const float* q,
                         float offset, double* product) {
  constexpr int kDots = 2;  // as many rows as the registers hold the lanes of
  std::vector<float> sums(static_cast<std::size_t>(padded));
  float dots[kBlockRows];
  double total = 0;
  InBlocks(rows, count, stride, [&](const float* block, int block_rows) {
    int r = 0;
    for (; r + kDots <= block_rows; r += kDots) {
      DotRows<kDots>(block + r * stride, stride, padded, q, dots + r);
    }
    for (; r < block_rows; ++r) DotRows<1>(block + r * stride, stride, padded, q, dots + r);
    for (r = 0; r < block_rows; ++r) total += static_cast<double>(dots[r] -= offset);

    std::fill(sums.begin(), sums.end(), 0.0f);
    for (r = 0; r + kTogether <= block_rows; r += kTogether) {
      AddMultiples<kTogether>(block + r * stride, stride, padded, dots + r, sums.data());
    }
    for (; r < block_rows; ++r) {
      AddMultiples<1>(block + r * stride, stride, padded, dots + r, sums.data());
    }
    for (int d = 0; d < padded; ++d) product[d] += static_cast<double>(sums[d]);
  });
  return total;
}

void ProjectRows(const float* rows, int count, int dimensions, const double* axis,
                 double* projections) {
  const int whole = dimensions / kRowLanes * kRowLanes;
  for (int r = 0; r < count; ++r, rows += dimensions) {
    Doubles lanes[2 * kVectors] = {};
    for (int d = 0; d < whole; d += kRowLanes) AddProducts(rows + d, axis + d, lanes);
    if (whole < dimensions) {  // what is left over is multiplied with zeros behind it
      float rest[kRowLanes] = {};
      std::memcpy(rest, rows + whole, (dimensions - whole) * sizeof(float));
      AddProducts(rest, axis + whole, lanes);
    }
    const Doubles sum = ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
                        ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
    projections[r] = sum[0] + sum[1];
  }
}

}  // namespace motiondb::core
