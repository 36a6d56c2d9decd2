#include "core/calibration/evidence_weight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::core {

double NegativeLogLikelihood(const std::vector<JudgedSample>& samples,
                             const EvidenceWeight& weight) {
  double sum = 0;
  for (const JudgedSample& sample : samples) {
    const double factor = weight.At(sample.frames);
    const double peak = *std::max_element(sample.evidence.begin(), sample.evidence.end());
    double exp_sum = 0;
    for (const double evidence : sample.evidence) exp_sum += std::exp(factor * (evidence - peak));
    sum += std::log(exp_sum) - factor * (sample.evidence[sample.label] - peak);
  }
  return sum / static_cast<double>(samples.size());
}

EvidenceWeight FitEvidenceWeight(const std::vector<JudgedSample>& samples,
                                 const std::vector<double>& powers) {
  constexpr int kScales = 65;
  constexpr double kMinLogScale = -6;
  constexpr double kMaxLogScale = 2;
  EvidenceWeight best;
  double min_loss = std::numeric_limits<double>::infinity();
  for (const double power : powers) {
    for (int i = 0; i < kScales; ++i) {
      const EvidenceWeight weight{
          std::exp(kMinLogScale + (kMaxLogScale - kMinLogScale) * i / (kScales - 1)), power};
      const double loss = NegativeLogLikelihood(samples, weight);
      if (loss < min_loss) {
        min_loss = loss;
        best = weight;
      }
    }
  }
  return best;
}

}  // namespace motiondb::core
