// Fits the weight of evidence with which label probabilities are calibrated.
#pragma once

#include <vector>

#include "core/model/recognition_calibration.h"

namespace motiondb::core {

// Evidence of a held-out observation.
struct JudgedSample {
  std::vector<double> evidence;  // log probability of each label, up to a constant
  std::size_t label = 0;         // the correct one
  int frames = 0;                // number of frames in the sum of the evidence
};

// Returns the mean negative log probability of the correct labels.
double NegativeLogLikelihood(const std::vector<JudgedSample>& samples,
                             const EvidenceWeight& weight);

// Returns the weight that maximizes the probability of the correct labels: scale from exp(-6) to
// exp(2), power one of `powers`. REQUIRES: samples are not empty.
EvidenceWeight FitEvidenceWeight(const std::vector<JudgedSample>& samples,
                                 const std::vector<double>& powers);

}  // namespace motiondb::core
