// Accuracy of labels.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct LabelPair {
  std::string truth;
  std::string named;
};

// Returns the fraction of correct labels. NaN if there are none.
double Accuracy(const std::vector<LabelPair>& names);

// Returns the accuracy over the names whose truth is `label`.
double AccuracyOf(const std::vector<LabelPair>& names, const std::string& label);

// Returns the mean of the accuracies of all labels that occur as truth.
double MacroAccuracy(const std::vector<LabelPair>& names);

}  // namespace motiondb::tests
