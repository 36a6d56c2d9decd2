// SIMD vectors of eight floats or four doubles for inner loops, and function multiversioning: one
// binary uses the widest vectors of the processor.
#pragma once

// Function attribute: compiles the function for all processors and for x86-64 with AVX2; the loader
// selects a version. Both yield the same bits, because products and sums are not fused (compiled
// with -ffp-contract=off). Called functions are inlined. Excluded: Clang 14 rejects 32-byte vectors
// as results of the functions below; the sanitizers are not initialised when the loader selects.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define MOTIONDB_WIDEST_VECTORS __attribute__((target_clones("avx2", "default"), flatten))
#else
#define MOTIONDB_WIDEST_VECTORS __attribute__((flatten))
#endif

namespace motiondb::core {

typedef float Floats __attribute__((vector_size(32)));
typedef int Ints __attribute__((vector_size(32)));
typedef double Doubles __attribute__((vector_size(32)));
typedef float FloatHalf __attribute__((vector_size(16)));
typedef double DoubleHalf __attribute__((vector_size(16)));

inline constexpr int kFloats = 8;   // numbers in Floats and Ints
inline constexpr int kDoubles = 4;  // numbers in Doubles and FloatHalf

// Loads and stores are unaligned.
template <typename V, typename T>
V LoadAs(const T* from) {
  static_assert(sizeof(V{}[0]) == sizeof(T));
  V v;
  __builtin_memcpy(&v, from, sizeof(V));
  return v;
}

inline Floats Load(const float* from) { return LoadAs<Floats>(from); }
inline FloatHalf LoadHalf(const float* from) { return LoadAs<FloatHalf>(from); }
inline Doubles Load(const double* from) { return LoadAs<Doubles>(from); }

template <typename V, typename T>
void Store(V v, T* to) {
  static_assert(sizeof(v[0]) == sizeof(T));
  __builtin_memcpy(to, &v, sizeof(V));
}

// Loads up to half a vector, padded with zeros.
inline FloatHalf LoadFew(const float* from, int count) {
  if (count >= kDoubles) return LoadHalf(from);
  FloatHalf few = {};
  for (int i = 0; i < count; ++i) few[i] = from[i];
  return few;
}

inline Doubles Widened(FloatHalf v) { return __builtin_convertvector(v, Doubles); }

// Returns the first half of a vector (i = 0) or the second (i = 1).
template <typename Half, typename V>
Half HalfOf(const V& v, int i) {
  static_assert(2 * sizeof(Half) == sizeof(V));
  Half half;
  __builtin_memcpy(&half, reinterpret_cast<const char*>(&v) + i * sizeof(Half), sizeof(Half));
  return half;
}

inline FloatHalf SumOfHalves(Floats v) { return HalfOf<FloatHalf>(v, 0) + HalfOf<FloatHalf>(v, 1); }
inline DoubleHalf SumOfHalves(Doubles v) {
  return HalfOf<DoubleHalf>(v, 0) + HalfOf<DoubleHalf>(v, 1);
}

inline float SumOf(FloatHalf v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace motiondb::core
