// Reproducible numbers and a digest, for results that must be bit-identical on every processor and
// with every compiler.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "core/motion/matrix.h"

namespace motiondb::tests {

// Returns rows x columns numbers, uniform in [-1, 1), from a linear congruential generator.
inline core::FrameMatrix FixedNumbers(Eigen::Index rows, Eigen::Index columns) {
  std::uint32_t state = 1;
  return core::FrameMatrix::NullaryExpr(rows, columns, [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<float>(state >> 8) / static_cast<float>(1 << 23) - 1.0F;
  });
}

// FNV-1a over the bits of the numbers, in 8-byte words. All NaN are equal.
class BitDigest {
 public:
  void Add(double number) {
    if (number != number) number = std::numeric_limits<double>::quiet_NaN();
    digest_ = (digest_ ^ std::bit_cast<std::uint64_t>(number)) * 1099511628211U;
  }
  template <typename Numbers>
  void AddAll(const Numbers& numbers) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) Add(numbers.data()[i]);
  }
  std::uint64_t value() const { return digest_; }

 private:
  std::uint64_t digest_ = 14695981039346656037U;
};

}  // namespace motiondb::tests
