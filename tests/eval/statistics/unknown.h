// The decision between known and unknown motion.
#pragma once

#include <string>
#include <vector>

namespace motiondb::tests {

struct UnknownAnswer {
  double score = 0;         // higher: unknown is more probable
  bool is_unknown = false;  // the truth
  std::string label;
  std::string subject;
};

// Returns the lowest of the scores such that at least a fraction `kept` of them is not above it.
// REQUIRES: `scores` is not empty.
double KeepingThreshold(std::vector<double> scores, double kept);

// Returns for each answer whether its score is above the threshold that keeps a fraction `kept` of
// the known answers of the other subjects. REQUIRES: the other subjects have known answers.
std::vector<bool> DecideUnknown(const std::vector<UnknownAnswer>& answers, double kept);

// Returns the fraction of the answers with this truth, and with this label unless it is empty, that
// are decided as unknown. NaN if there are none.
double DecidedUnknown(const std::vector<UnknownAnswer>& answers, const std::vector<bool>& decided,
                      bool is_unknown, const std::string& label = "");

}  // namespace motiondb::tests
