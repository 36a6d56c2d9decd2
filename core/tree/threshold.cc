#include "core/tree/threshold.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::core {
namespace {

// Equal values have variance 0 and a logarithm of minus infinity: below this part of the whole
// variance, differences are rounding.
constexpr double kRelativeFloor = 1e-12;

struct Moments {
  double count = 0;
  double sum = 0;
  double squares = 0;

  double variance() const { return squares / count - (sum / count) * (sum / count); }
};

}  // namespace

int MinimumErrorThreshold(std::span<const double> sorted) {
  const auto n = static_cast<int>(sorted.size());
  if (n < 4) return 0;
  double mean = 0;
  for (double s : sorted) mean += s;
  mean /= n;
  Moments all{.count = static_cast<double>(n)};
  for (double s : sorted) {
    all.sum += s - mean;
    all.squares += (s - mean) * (s - mean);
  }
  if (!(all.variance() > 0) || sorted.front() == sorted.back()) return 0;
  const double floor = kRelativeFloor * all.variance();

  int best = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  Moments left;
  for (int i = 1; i <= n - 2; ++i) {
    const double s = sorted[i - 1] - mean;
    left.count = i;
    left.sum += s;
    left.squares += s * s;
    if (i < 2) continue;
    const Moments right{all.count - left.count, all.sum - left.sum, all.squares - left.squares};
    const double cost = left.count * std::log(std::max(left.variance(), floor) / left.count) +
                        right.count * std::log(std::max(right.variance(), floor) / right.count);
    if (cost < best_cost) {
      best_cost = cost;
      best = i;
    }
  }
  return best;
}

}  // namespace motiondb::core
