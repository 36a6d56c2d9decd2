#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/tree/split_node.h"

namespace motiondb::tests::threshold_test {
namespace {

double Variance(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  double mean = 0;
  for (std::size_t i = begin; i < end; ++i) mean += values[i];
  mean /= static_cast<double>(end - begin);
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += (values[i] - mean) * (values[i] - mean);
  return sum / static_cast<double>(end - begin);
}

// Eq. 5 literally, minimized: two passes for every cut.
int SlowThreshold(const std::vector<double>& sorted) {
  const std::size_t n = sorted.size();
  double best = std::numeric_limits<double>::infinity();
  int at = 0;
  for (std::size_t i = 2; i + 2 <= n; ++i) {
    const auto left = static_cast<double>(i);
    const auto right = static_cast<double>(n - i);
    const double cost = left * std::log(Variance(sorted, 0, i) / left) +
                        right * std::log(Variance(sorted, i, n) / right);
    if (cost < best) {
      best = cost;
      at = static_cast<int>(i);
    }
  }
  return at;
}

}  // namespace

TEST_CASE("Threshold: equals eq. 5 computed cut by cut", "[core][tree]") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::normal_distribution<double> first_group(0, 1);
    std::normal_distribution<double> second_group(trial % 7, 0.5);
    std::vector<double> values;
    const int n = 4 + trial;
    for (int i = 0; i < n; ++i)
      values.push_back(i % 3 == 0 ? second_group(random) : first_group(random));
    std::sort(values.begin(), values.end());
    CHECK(core::MinimumErrorThreshold(values) == SlowThreshold(values));
  }
}

TEST_CASE("Threshold: two groups far apart are cut between them", "[core][tree]") {
  std::vector<double> values;
  for (int i = 0; i < 30; ++i) values.push_back(0.01 * i);
  for (int i = 0; i < 50; ++i) values.push_back(100 + 0.01 * i);
  CHECK(core::MinimumErrorThreshold(values) == 30);
}

TEST_CASE("Threshold: no cut without separate groups", "[core][tree]") {
  CHECK(core::MinimumErrorThreshold(std::vector<double>{}) == 0);
  CHECK(core::MinimumErrorThreshold(std::vector<double>{1, 2, 3}) == 0);
  CHECK(core::MinimumErrorThreshold(std::vector<double>(100, 2.5)) == 0);
}

TEST_CASE("Threshold: handles runs of equal values", "[core][tree]") {
  std::vector<double> values(40, 0.0);
  values.insert(values.end(), 40, 1.0);
  CHECK(core::MinimumErrorThreshold(values) == 40);
}

}  // namespace motiondb::tests::threshold_test
