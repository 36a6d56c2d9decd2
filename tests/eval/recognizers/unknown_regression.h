// The probability that an observation has none of a peer's labels, from its scores.
#pragma once

#include <optional>
#include <vector>

#include "tests/eval/recognizers/cross_validation.h"

namespace motiondb::tests {

// P(unknown) = 1 / (1 + exp(-(intercept + score_weight s + odds_weight o))). s: the best score.
// o: log odds x of the best label by Softmax, bounded: x / (1 + |x| / 4).
struct UnknownRegression {
  double temperature = 1;
  double intercept = 0;
  double score_weight = 0;
  double odds_weight = 0;

  double Probability(const std::vector<double>& scores) const;
};

// Fits the regression to motions held out with their subject. Each is a known sample with all its
// scores, and an unknown sample without the score of its own label. If the fold did not learn its
// label, it is only an unknown sample.
//
// Fitted by the regression of the database (core/calibration/recognition_fit.h).
std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOut>& held_out,
                                                      double temperature);

}  // namespace motiondb::tests
