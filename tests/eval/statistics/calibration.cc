#include "tests/eval/statistics/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::tests {

std::vector<ReliabilityBin> Reliability(const std::vector<Claim>& claims, int bins) {
  std::vector<ReliabilityBin> table(static_cast<std::size_t>(bins));
  for (int b = 0; b < bins; ++b) {
    table[b].lower = static_cast<double>(b) / bins;
    table[b].upper = static_cast<double>(b + 1) / bins;
  }
  for (const Claim& claim : claims) {
    const int b = std::clamp(static_cast<int>(std::ceil(claim.confidence * bins)) - 1, 0, bins - 1);
    ++table[b].count;
    table[b].confidence += claim.confidence;
    table[b].accuracy += claim.right;
  }
  for (ReliabilityBin& bin : table) {
    if (bin.count == 0) continue;
    bin.confidence /= bin.count;
    bin.accuracy /= bin.count;
  }
  return table;
}

double CalibrationError(const std::vector<ReliabilityBin>& reliability) {
  double error = 0;
  int count = 0;
  for (const ReliabilityBin& bin : reliability) {
    error += bin.count * std::abs(bin.accuracy - bin.confidence);
    count += bin.count;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : error / count;
}

}  // namespace motiondb::tests
