// Calibration of recognition, fitted to held-out stored clips; stored with the model.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace motiondb::core {

// Successive frames are not independent, so the evidence of m frames is their sum times
// scale * m^(power - 1). With scale 1, power 1 is the sum and power 0 the mean.
struct EvidenceWeight {
  double scale = 1;
  double power = 1;

  double At(int frames) const { return scale * std::pow(frames, power - 1); }
};

struct AnswerCalibration {
  EvidenceWeight weight;
  std::vector<float> familiarity;  // scores of held-out observations, ascending

  // Returns the fraction of held-out observations with a lower score, 0 to 1.
  double FamiliarityRank(double score) const {
    const auto lower =
        std::lower_bound(familiarity.begin(), familiarity.end(), static_cast<float>(score));
    return static_cast<double>(lower - familiarity.begin()) /
           static_cast<double>(std::max<std::size_t>(1, familiarity.size()));
  }
};

// The default weights are typical values, for models that are not calibrated.
struct RecognitionCalibration {
  AnswerCalibration window{{0.07, 1}, {}};
  AnswerCalibration whole{{0.25, 0.25}, {}};

  const AnswerCalibration& Of(bool whole_observation) const {
    return whole_observation ? whole : window;
  }
};

}  // namespace motiondb::core
