// Does a confidence mean what it says?
#pragma once

#include <vector>

namespace motiondb::tests {

struct Claim {
  double confidence = 0;  // 0 to 1
  bool right = false;
};

struct ReliabilityBin {
  double lower = 0;  // confidences in (lower, upper]; the first bin has 0 too
  double upper = 0;
  int count = 0;
  double confidence = 0;  // mean; 0 where the bin is empty
  double accuracy = 0;
};

// Claims in `bins` bins of equal width.
std::vector<ReliabilityBin> Reliability(const std::vector<Claim>& claims, int bins = 10);

// Expected calibration error: |accuracy - confidence| of each bin, weighted by its share of the
// claims. NaN where there is none.
double CalibrationError(const std::vector<ReliabilityBin>& reliability);

}  // namespace motiondb::tests
