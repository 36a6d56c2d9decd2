#include "core/recognition/unknown.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::core {
namespace {

constexpr double kFitBound = 6;
constexpr double kDistanceOfEvidence = 6;  // a log density is -distance / 6 (clip_alignment.h)
constexpr double kMinDistance = 1e-3;      // a motion compared with itself has evidence about 0
constexpr double kNoiseError = 0.02;       // relative error of the noise, about its deviation

// Returns the part of a squared distance that is not noise.
double WithoutNoise(double squared_distance, double noise) {
  return std::max({kMinDistance, kNoiseError * noise, squared_distance - noise});
}

double UnknownProbability(const UnknownModel& model, const std::string& label,
                          const BestLabel& best) {
  const auto fit = std::ranges::lower_bound(model.fits, label, {}, &LabelFit::label);
  const bool has_fit = fit != model.fits.end() && fit->label == label;
  const auto features = UnknownFeatures(best, has_fit ? fit->mean : model.typical_mean,
                                        has_fit ? fit->deviation : model.typical_deviation);
  double log_odds = model.intercept;
  for (std::size_t i = 0; i < features.size(); ++i) log_odds += model.weights[i] * features[i];
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace

double FitWithoutNoise(double evidence, const WindowAlignment& alignment) {
  return -WithoutNoise(-kDistanceOfEvidence * evidence / alignment.frames, alignment.noise) /
         kDistanceOfEvidence;
}

BestLabel FindBestLabel(const std::vector<double>& evidence, const WindowAlignment& alignment) {
  BestLabel best;
  best.label = static_cast<std::size_t>(std::ranges::max_element(evidence) - evidence.begin());
  best.fit = FitWithoutNoise(evidence[best.label], alignment);
  double second = -std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < evidence.size(); ++l) {
    if (l != best.label) second = std::max(second, evidence[l]);
  }
  if (std::isfinite(second)) best.lead = std::log(FitWithoutNoise(second, alignment) / best.fit);
  return best;
}

std::array<double, UnknownModel::kFeatures> UnknownFeatures(const BestLabel& best, double mean,
                                                            double deviation) {
  const double x = (best.fit - mean) / deviation;
  return {x / (1 + std::abs(x) / kFitBound), best.lead};
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
