// How often the right label is named.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct Named {
  std::string truth;
  std::string named;
};

// Share of right names, 0 to 1. NaN where there is none.
double Accuracy(const std::vector<Named>& names);

// The same over those whose truth is `label`.
double AccuracyOf(const std::vector<Named>& names, const std::string& label);

// Mean over the labels that occur as truth of the accuracy of each.
double MacroAccuracy(const std::vector<Named>& names);

}  // namespace motiondb::tests
