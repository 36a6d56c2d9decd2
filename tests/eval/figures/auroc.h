// How well a score tells the known from the unknown.
#pragma once

#include <vector>

namespace motiondb::tests {

// Area under the receiver operating characteristic: the probability that a known scores higher than
// an unknown, ties counting half. NaN where either is empty. O(n log n).
double Auroc(const std::vector<double>& known, const std::vector<double>& unknown);

}  // namespace motiondb::tests
