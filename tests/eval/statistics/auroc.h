// Separation of known from unknown motion by a score.
#pragma once

#include <vector>

namespace motiondb::tests {

// Returns the area under the receiver operating characteristic: the probability that a known motion
// scores higher than an unknown one; ties count half. NaN if either is empty. O(n log n).
double Auroc(const std::vector<double>& known, const std::vector<double>& unknown);

}  // namespace motiondb::tests
