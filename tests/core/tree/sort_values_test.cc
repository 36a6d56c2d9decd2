#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "core/tree/permuted_states.h"
#include "tests/core/tree/threads.h"

namespace motiondb::tests::sort_values_test {
namespace {

enum class Shape { kEven, kNormal, kHeavyTails, kTwoFar, kFew, kSame, kSorted };

std::vector<double> Values(Shape shape, int count) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    const double x = normal(random);
    switch (shape) {
      case Shape::kEven:
        values.push_back(static_cast<double>(random()) / 7);
        break;
      case Shape::kNormal:
        values.push_back(x);
        break;
      case Shape::kHeavyTails:
        values.push_back(std::sinh(9 * x));
        break;
      case Shape::kTwoFar:
        values.push_back(i % 3 == 0 ? 1e9 : 1e-9 * x);
        break;
      case Shape::kFew:
        values.push_back(std::floor(2 * x));
        break;
      case Shape::kSame:
        values.push_back(-2.5);
        break;
      case Shape::kSorted:
        values.push_back(i);
        break;
    }
  }
  return values;
}

}  // namespace

TEST_CASE("SortValues: sorts all distributions, on any threads", "[core][tree]") {
  for (const Shape shape : {Shape::kEven, Shape::kNormal, Shape::kHeavyTails, Shape::kTwoFar,
                            Shape::kFew, Shape::kSame, Shape::kSorted}) {
    for (const int count : {0, 1, 2, 64, 65, 1000, 32767, 32768, 100'000}) {
      const std::vector<double> values = Values(shape, count);
      std::vector<double> expected = values;
      std::sort(expected.begin(), expected.end());
      std::vector<double> scratch(values.size());
      for (const core::ParallelFor& parallel :
           {core::ParallelFor(core::RunSerially), core::ParallelFor(OnFourThreads)}) {
        std::vector<double> sorted = values;
        core::SortValues(sorted, scratch, parallel);
        CAPTURE(static_cast<int>(shape), count);
        CHECK(sorted == expected);
      }
    }
  }
}

}  // namespace motiondb::tests::sort_values_test
