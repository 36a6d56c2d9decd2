// How good a prediction is, told from what went into it; fitted on stored clips that are predicted
// without themselves. Plain values; pure functions.
#pragma once

#include <array>
#include <vector>

namespace motiondb::core {

// What is known of a prediction when it is made (core/prediction/forecast.h).
struct PredictionEvidence {
  double variance = 1;
  double spread = 0;  // leg lengths
  double speed = 0;   // leg lengths
};

// The logarithm of the mean marker error (leg lengths) at one horizon is Gaussian about a linear
// function of the logarithms of the evidence.
struct ErrorModel {
  double seconds = 0;
  std::array<double, 4> coefficients{};  // constant, variance, spread, speed
  std::array<double, 3> lowest{};        // logarithms of the evidence are clamped to what was seen
  std::array<double, 3> highest{};
  double deviation = 0;
};

struct ExpectedError {
  double mean = 0;         // leg lengths
  double probability = 0;  // that it is below the limit
};

struct PredictionConfidence {
  std::vector<ErrorModel> laws;  // horizons ascending; empty where there was too little to fit to

  // Interpolated between horizons; before the first and after the last it is theirs. Where there
  // are no laws the error is not known (0) and the probability is 1 less the variance: not
  // calibrated.
  ExpectedError Judge(const PredictionEvidence& evidence, double at_seconds, double limit) const;
};

// The law that fits errors (leg lengths, above 0) best, least squares on the logarithms. At least
// two samples.
struct ErrorSample {
  PredictionEvidence evidence;
  double error = 0;
};
ErrorModel FitErrorLaw(double seconds, const std::vector<ErrorSample>& samples);

}  // namespace motiondb::core
