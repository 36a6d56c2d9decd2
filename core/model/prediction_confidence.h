// The error model of predictions: expected error as a function of the inputs of a prediction.
// Fitted to held-out stored clips.
#pragma once

#include <array>
#include <vector>

namespace motiondb::core {

// Inputs of the error model (core/prediction/forecast.h).
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
  std::array<double, 3> lowest{};        // logarithms of the evidence are clamped to this range
  std::array<double, 3> highest{};
  double deviation = 0;
};

struct ExpectedError {
  double mean = 0;         // leg lengths
  double probability = 0;  // probability that the error is below the limit
};

struct PredictionConfidence {
  std::vector<ErrorModel> models;  // horizons ascending; empty if there were too few samples

  // Returns whether a horizon is longer than those of the error models. False without any.
  bool IsBeyond(double seconds) const;
  // Returns the expected error, interpolated between horizons and constant outside them. Without
  // error models: error 0 (unknown) and probability 1 - variance, not calibrated.
  ExpectedError Judge(const PredictionEvidence& evidence, double at_seconds, double limit) const;
};

struct ErrorSample {
  PredictionEvidence evidence;
  double error = 0;  // leg lengths, above 0
};

// Returns the error model that fits best: least squares on the logarithms. REQUIRES: at least two
// samples.
ErrorModel FitErrorModel(double seconds, const std::vector<ErrorSample>& samples);

}  // namespace motiondb::core
