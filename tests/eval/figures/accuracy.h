// Accuracy of labels.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct Named {
  std::string truth;
  std::string named;
};

// Returns the fraction of correct labels. NaN if there are none.
double Accuracy(const std::vector<Named>& names);

// Returns the accuracy over the names whose truth is `label`.
double AccuracyOf(const std::vector<Named>& names, const std::string& label);

// Returns the mean of the accuracies of all labels that occur as truth.
double MacroAccuracy(const std::vector<Named>& names);

}  // namespace motiondb::tests
