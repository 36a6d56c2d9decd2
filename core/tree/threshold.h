// Minimum-error thresholding (section III-B, eq. 5, after Kittler and Illingworth) of the
// projections onto the principal axis.
#pragma once

#include <span>

namespace motiondb::core {

// Where to cut sorted values: the i in [2, n - 2] that minimises
//   J(i) = i log(var1 / i) + (n - i) log(var2 / (n - i)),
// var1 and var2 being the population variances of the first i and the last n - i values; the
// smallest such i of equals. (The paper prints argmax, which splits off single frames. A side needs
// two values to have a variance.) 0 where there is no cut: n < 4 or all values equal. `sorted` is
// ascending. O(n).
int MinimumErrorThreshold(std::span<const double> sorted);

}  // namespace motiondb::core
