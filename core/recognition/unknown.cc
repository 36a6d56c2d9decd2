#include "core/recognition/unknown.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::core {
namespace {

constexpr double kDistanceOfEvidence = 6;  // a log density is -distance / 6 (clip_alignment.h)
constexpr double kMinDistance = 1e-3;      // a motion compared with itself has evidence about 0
constexpr double kNoiseError = 0.02;       // relative error of the noise, about its deviation

double UnknownProbability(const UnknownModel& model, const std::string& label,
                          const BestLabel& best) {
  const auto of_label = std::ranges::lower_bound(model.labels, label, {}, &LabelDistance::label);
  const bool is_fitted = of_label != model.labels.end() && of_label->label == label;
  const auto features =
      UnknownFeatures(best, is_fitted ? of_label->log_distance : model.typical_log_distance);
  double log_odds = model.intercept;
  for (std::size_t i = 0; i < features.size(); ++i) log_odds += model.weights[i] * features[i];
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace

double LogDistance(double evidence, const WindowAlignment& alignment) {
  const double distance = -kDistanceOfEvidence * evidence / alignment.frames;
  return std::log(
      std::max({kMinDistance, kNoiseError * alignment.noise, distance - alignment.noise}));
}

BestLabel FindBestLabel(const std::vector<double>& evidence, const WindowAlignment& alignment) {
  BestLabel best;
  best.label = static_cast<std::size_t>(std::ranges::max_element(evidence) - evidence.begin());
  best.log_distance = LogDistance(evidence[best.label], alignment);
  double second = -std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < evidence.size(); ++l) {
    if (l != best.label) second = std::max(second, evidence[l]);
  }
  if (std::isfinite(second)) best.lead = LogDistance(second, alignment) - best.log_distance;
  return best;
}

std::array<double, UnknownModel::kFeatures> UnknownFeatures(const BestLabel& best,
                                                            double typical_log_distance) {
  return {best.log_distance - typical_log_distance, best.lead};
}

LabelAnswer LabelsOrUnknown(const std::vector<std::string>& labels,
                            const WindowAlignment& alignment,
                            const AnswerCalibration& calibration) {
  const std::vector<double> evidence = LabelEvidence(labels.size(), alignment.units);
  LabelAnswer answer;
  if (calibration.unknown && !labels.empty()) {
    const BestLabel best = FindBestLabel(evidence, alignment);
    answer.unknown_probability = UnknownProbability(*calibration.unknown, labels[best.label], best);
  }
  answer.labels = LabelsByAlignment(labels, evidence, calibration.weight.At(alignment.frames));
  for (LabelScore& score : answer.labels) {
    score.probability *= 1 - answer.unknown_probability.value_or(0);
  }
  return answer;
}

}  // namespace motiondb::core
