// Calibration of confidences.
#pragma once

#include <vector>

namespace motiondb::tests {

struct Claim {
  double confidence = 0;  // 0 to 1
  bool right = false;
};

struct ReliabilityBin {
  double lower = 0;  // confidences in (lower, upper]; the first bin includes 0
  double upper = 0;
  int count = 0;
  double confidence = 0;  // mean; 0 if the bin is empty
  double accuracy = 0;
};

// Distributes claims over `bins` bins of equal width.
std::vector<ReliabilityBin> Reliability(const std::vector<Claim>& claims, int bins = 10);

// Returns the expected calibration error: the mean of |accuracy - confidence| over the bins,
// weighted by their claims. NaN if there are none.
double CalibrationError(const std::vector<ReliabilityBin>& reliability);

}  // namespace motiondb::tests
