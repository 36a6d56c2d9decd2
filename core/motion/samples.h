// Samples of numbers: evenly spread indices, and order statistics.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

namespace motiondb::core {

// Returns at most `max_count` of the indices 0 to count - 1, evenly spread, ascending. Empty if
// either number is not positive.
inline std::vector<int> SpreadEvenly(std::int64_t count, std::int64_t max_count) {
  const std::int64_t kept = std::min(count, max_count);
  std::vector<int> spread;
  for (std::int64_t i = 0; i < kept; ++i) spread.push_back(static_cast<int>(i * count / kept));
  return spread;
}

// Order statistics. The functions reorder `values`, which have no NaN. O(size).

// Returns the value that has this rank: its index after sorting. REQUIRES: `rank` is in [0, size).
template <typename Number>
Number ValueOfRank(std::vector<Number>& values, std::ptrdiff_t rank) {
  const auto at = values.begin() + rank;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Returns the median; of an even number of values the upper one. REQUIRES: not empty.
template <typename Number>
Number Median(std::vector<Number>& values) {
  return ValueOfRank(values, std::ssize(values) / 2);
}

// Returns the quantile `share` (0 to 1), without interpolation: the value whose rank is
// share * (size - 1), rounded down. REQUIRES: not empty.
template <typename Number>
Number Quantile(std::vector<Number>& values, double share) {
  const double last = static_cast<double>(std::ssize(values) - 1);
  return ValueOfRank(values, static_cast<std::ptrdiff_t>(share * last));
}

}  // namespace motiondb::core
