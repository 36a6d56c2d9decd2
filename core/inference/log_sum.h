// Sums of probabilities that are kept as logarithms. Pure.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace motiondb::core {

// log of the sum of exp(logs), which are not empty; -infinity where all are.
inline double LogSum(const std::vector<double>& logs) {
  const double peak = *std::max_element(logs.begin(), logs.end());
  if (!std::isfinite(peak)) return peak;
  double sum = 0;
  for (double log : logs) sum += std::exp(log - peak);
  return peak + std::log(sum);
}

}  // namespace motiondb::core
