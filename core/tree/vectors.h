// Vectors of kWidth numbers (and of as many bytes of others), for loops that are compiled once for
// every processor, in vectors of four, and once for those that have wider ones. A file that is may
// use more than every processor has, so what it is made of calls no function that another file
// could share (an inline one of the standard library, say). Pure.
#pragma once

namespace motiondb::core {

template <int kWidth>
struct VectorTypes;

template <>
struct VectorTypes<4> {
  typedef float Floats __attribute__((vector_size(16)));
  typedef int Ints __attribute__((vector_size(16)));
  typedef float FloatHalf __attribute__((vector_size(8)));
  typedef double Doubles __attribute__((vector_size(16)));
};

template <>
struct VectorTypes<8> {
  typedef float Floats __attribute__((vector_size(32)));
  typedef int Ints __attribute__((vector_size(32)));
  typedef float FloatHalf __attribute__((vector_size(16)));
  typedef double Doubles __attribute__((vector_size(32)));
};

template <int kWidth>
struct Vectors : VectorTypes<kWidth> {
  static constexpr int kHalf = kWidth / 2;
  using Floats = typename VectorTypes<kWidth>::Floats;
  using Ints = typename VectorTypes<kWidth>::Ints;
  using FloatHalf = typename VectorTypes<kWidth>::FloatHalf;  // half as many
  using Doubles = typename VectorTypes<kWidth>::Doubles;      // half as many

  // From and to any address.
  static Floats Load(const float* from) { return LoadAs<Floats>(from); }
  static FloatHalf LoadHalf(const float* from) { return LoadAs<FloatHalf>(from); }
  static Doubles LoadDoubles(const double* from) { return LoadAs<Doubles>(from); }
  template <typename V, typename T>
  static void Store(V v, T* to) {
    static_assert(sizeof(v[0]) == sizeof(T));
    __builtin_memcpy(to, &v, sizeof(V));
  }

  // Up to half a vector, then zeros.
  static FloatHalf LoadFew(const float* from, int count) {
    if (count >= kHalf) return LoadHalf(from);
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

 private:
  template <typename V, typename T>
  static V LoadAs(const T* from) {
    static_assert(sizeof(V{}[0]) == sizeof(T));
    V v;
    __builtin_memcpy(&v, from, sizeof(V));
    return v;
  }
};

}  // namespace motiondb::core
