// Calibration of the answers of recognition and prediction, fitted to held-out stored clips; stored
// with the model.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace motiondb::core {

// Successive frames are not independent, so the evidence of m frames is their sum times
// scale * m^(power - 1). With scale 1, power 1 is the sum and power 0 the mean.
struct EvidenceWeight {
  double scale = 1;
  double power = 1;

  double At(int frames) const { return scale * std::pow(frames, power - 1); }
};

// How much held-out clips of a label differ from the label's other clips.
struct LabelDistance {
  std::string label;
  double log_distance = 0;  // LogDistance of core/recognition/unknown.h, mean over the clips
};

// Logistic regression of the probability that a motion has none of the stored labels, from the
// features of core/recognition/unknown.h.
struct UnknownModel {
  static constexpr int kFeatures = 2;

  double intercept = 0;
  std::array<double, kFeatures> weights = {};
  double typical_log_distance = 0;    // of a label that is not in `labels`
  std::vector<LabelDistance> labels;  // ascending by label
};

struct AnswerCalibration {
  EvidenceWeight weight;
  std::vector<float> familiarity;  // scores of held-out observations, ascending
  std::optional<UnknownModel> unknown;

  // Returns the fraction of held-out observations with a lower score, 0 to 1.
  double FamiliarityRank(double score) const {
    const auto lower =
        std::lower_bound(familiarity.begin(), familiarity.end(), static_cast<float>(score));
    return static_cast<double>(lower - familiarity.begin()) /
           static_cast<double>(std::max<std::size_t>(1, familiarity.size()));
  }
};

// Whether the calibration has an UnknownModel, or why not. The numbers are stored.
enum class UnknownCalibration {
  kFitted,       // it has
  kNotFitted,    // the model is not calibrated, or was by an older version
  kOneClip,      // no clip can be held out
  kOneLabel,     // no label can be held out
  kOneSubject,   // fewer than two subjects are named
  kTooFewClips,  // too few clips remain if a subject or a label is held out
};

// The default weights are typical values, for models that are not calibrated.
struct RecognitionCalibration {
  AnswerCalibration window{{0.07, 1}, {}, {}};
  AnswerCalibration whole{{0.25, 0.25}, {}, {}};
  UnknownCalibration unknown = UnknownCalibration::kNotFitted;

  const AnswerCalibration& Of(bool whole_observation) const {
    return whole_observation ? whole : window;
  }
};

// The error model of predictions: the expected error as a function of the inputs of a prediction.

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
