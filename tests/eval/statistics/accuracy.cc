#include "tests/eval/statistics/accuracy.h"

#include <algorithm>
#include <limits>
#include <set>

namespace motiondb::tests {

double Accuracy(const std::vector<LabelPair>& names) {
  if (names.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto right = std::count_if(names.begin(), names.end(),
                                   [](const LabelPair& n) { return n.truth == n.named; });
  return static_cast<double>(right) / static_cast<double>(names.size());
}

double AccuracyOf(const std::vector<LabelPair>& names, const std::string& label) {
  std::vector<LabelPair> of_label;
  std::copy_if(names.begin(), names.end(), std::back_inserter(of_label),
               [&](const LabelPair& n) { return n.truth == label; });
  return Accuracy(of_label);
}

double MacroAccuracy(const std::vector<LabelPair>& names) {
  std::set<std::string> labels;
  for (const LabelPair& n : names) labels.insert(n.truth);
  if (labels.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (const std::string& label : labels) sum += AccuracyOf(names, label);
  return sum / static_cast<double>(labels.size());
}

}  // namespace motiondb::tests
