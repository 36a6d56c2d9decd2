// How much evidence has to be taken back until probabilities are right. Pure.
#pragma once

#include <vector>

#include "core/model/recognition_calibration.h"

namespace motiondb::core {

// What a held-out observation was said to be.
struct JudgedSample {
  std::vector<double> evidence;  // of each label, natural logarithms
  std::size_t label = 0;         // what it is
  int frames = 0;                // that the evidence is summed over
};

// The mean negative log probability of the right labels.
double NegativeLogLikelihood(const std::vector<JudgedSample>& samples,
                             const EvidenceWeight& weight);

// The weight under which the right labels are most probable: scale from exp(-6) to exp(2), power
// one of `powers`. `samples` are not empty.
EvidenceWeight FitEvidenceWeight(const std::vector<JudgedSample>& samples,
                                 const std::vector<double>& powers);

}  // namespace motiondb::core
