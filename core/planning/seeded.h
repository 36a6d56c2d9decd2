// Seeded random numbers, identical on every machine, unlike the distributions of the standard
// library.
#pragma once

#include <cstdint>

namespace motiondb::core {

// Hashes a number (output function of SplitMix64).
inline std::uint64_t Mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

// Uniform in [0, 1).
inline double ToUnit(std::uint64_t mixed) { return static_cast<double>(mixed >> 11U) * 0x1.0p-53; }

// A sequence of uniform random numbers.
class SeededSequence {
 public:
  explicit SeededSequence(std::uint64_t seed) : state_(Mix(seed)) {}
  double Next() { return ToUnit(Mix(++state_)); }
  double Between(double low, double high) { return low + (high - low) * Next(); }

 private:
  std::uint64_t state_;
};

}  // namespace motiondb::core
