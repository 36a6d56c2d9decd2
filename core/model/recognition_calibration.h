// Calibration of recognition, fitted to held-out stored clips; stored with the model.
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

}  // namespace motiondb::core
