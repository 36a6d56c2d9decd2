#include "core/recognition/unknown.h"

#include <algorithm>
#include <cmath>

#include "core/inference/lattice.h"

namespace motiondb::core {
namespace {

constexpr double kFitBound = 6;
constexpr double kOddsBound = 4;
constexpr double kDistanceOfEvidence = 6;  // a log density is -distance / 6 (clip_alignment.h)
constexpr double kMinDistance = 1e-3;      // a motion compared with itself has evidence about 0
constexpr double kNoiseError = 0.02;       // relative error of the noise, about its deviation

// Returns the part of a squared distance that is not noise.
double WithoutNoise(double squared_distance, double noise) {
  return std::max({kMinDistance, kNoiseError * noise, squared_distance - noise});
}

double Bounded(double x, double bound) { return x / (1 + std::abs(x) / bound); }

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

BestLabel FindBestLabel(const std::vector<double>& evidence, const WindowAlignment& alignment,
                        const EvidenceWeight& weight) {
  BestLabel best;
  best.label = static_cast<std::size_t>(std::max_element(evidence.begin(), evidence.end()) -
                                        evidence.begin());
  best.fit = FitWithoutNoise(evidence[best.label], alignment);
  best.unexplained =
      std::log(-kDistanceOfEvidence * best.fit / WithoutNoise(alignment.energy, alignment.noise));
  std::vector<double> others;
  for (std::size_t l = 0; l < evidence.size(); ++l) {
    if (l != best.label && std::isfinite(evidence[l]))
      others.push_back(weight.At(alignment.frames) * evidence[l]);
  }
  if (!others.empty()) {
    best.log_odds = weight.At(alignment.frames) * evidence[best.label] - LogSum(others);
  }
  return best;
}

std::array<double, UnknownModel::kFeatures> UnknownFeatures(const BestLabel& best, double mean,
                                                            double deviation) {
  return {best.unexplained, Bounded((best.fit - mean) / deviation, kFitBound),
          Bounded(best.log_odds, kOddsBound)};
}

LabelAnswer LabelsOrUnknown(const std::vector<std::string>& labels,
                            const WindowAlignment& alignment,
                            const AnswerCalibration& calibration) {
  const std::vector<double> evidence = LabelEvidence(labels.size(), alignment.units);
  LabelAnswer answer;
  if (calibration.unknown && !labels.empty()) {
    const BestLabel best = FindBestLabel(evidence, alignment, calibration.weight);
    answer.unknown_probability = UnknownProbability(*calibration.unknown, labels[best.label], best);
  }
  answer.labels = LabelsByAlignment(labels, evidence, calibration.weight.At(alignment.frames));
  for (LabelScore& score : answer.labels) {
    score.probability *= 1 - answer.unknown_probability.value_or(0);
  }
  return answer;
}

}  // namespace motiondb::core
