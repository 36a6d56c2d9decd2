#include "tests/eval/statistics/auroc.h"

#include <algorithm>
#include <limits>

namespace motiondb::tests {

double Auroc(const std::vector<double>& known, const std::vector<double>& unknown) {
  if (known.empty() || unknown.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = unknown;
  std::sort(sorted.begin(), sorted.end());
  double wins = 0;
  for (double score : known) {
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), score);
    wins += static_cast<double>(first - sorted.begin()) + 0.5 * static_cast<double>(last - first);
  }
  return wins / (static_cast<double>(known.size()) * static_cast<double>(unknown.size()));
}

}  // namespace motiondb::tests
