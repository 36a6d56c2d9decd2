// Fits the weight of the evidence, which calibrates label probabilities.
#pragma once

#include <vector>

#include "core/model/recognition_calibration.h"

namespace motiondb::core {

// A held-out observation.
struct JudgedSample {
  std::vector<double> evidence;  // log probability of each label, up to a constant
  std::size_t label = 0;         // index of the correct label
  int frames = 0;                // number of frames that the evidence sums over
};

// Returns the mean of -log p over the samples. p: probability of the correct label,
// softmax(weight.At(frames) * evidence)[label].
double NegativeLogLikelihood(const std::vector<JudgedSample>& samples,
                             const EvidenceWeight& weight);

// Returns the weight with the minimum NegativeLogLikelihood. Searches scales from exp(-6) to exp(2)
// and all `powers`. REQUIRES: `samples` is not empty.
EvidenceWeight FitEvidenceWeight(const std::vector<JudgedSample>& samples,
                                 const std::vector<double>& powers);

}  // namespace motiondb::core
