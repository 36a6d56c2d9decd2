// What recognition's evidence is worth, as found on stored clips that were held out. Plain values,
// kept with the model.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace motiondb::core {

// Frames that follow each other say nearly the same, so evidence summed over m of them counts for
// scale * m^(power - 1) of its sum: power 1 takes the sum as it is, 0 its mean.
struct EvidenceWeight {
  double scale = 1;
  double power = 1;

  double At(int frames) const { return scale * std::pow(frames, power - 1); }
};

struct AnswerCalibration {
  EvidenceWeight weight;
  std::vector<float> familiarity;  // scores of held-out observations, ascending

  // Fraction of held-out observations that score lower, in [0, 1].
  double FamiliarityRank(double score) const {
    const auto lower =
        std::lower_bound(familiarity.begin(), familiarity.end(), static_cast<float>(score));
    return static_cast<double>(lower - familiarity.begin()) /
           static_cast<double>(std::max<std::size_t>(1, familiarity.size()));
  }
};

// The weights here are typical ones, for a model that was not calibrated.
struct RecognitionCalibration {
  AnswerCalibration window{{0.07, 1}, {}};
  AnswerCalibration whole{{0.25, 0.25}, {}};

  const AnswerCalibration& Of(bool whole_observation) const {
    return whole_observation ? whole : window;
  }
};

}  // namespace motiondb::core
