#include "tests/eval/recognizers/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tests/eval/recognizers/recognizer.h"

namespace motiondb::tests {
namespace {

constexpr int kDealtFolds = 3;
constexpr int kTemperatures = 161;

bool HaveAllLabels(const std::vector<Fold>& folds, const std::vector<std::string>& labels) {
  return std::all_of(folds.begin(), folds.end(),
                     [&](const Fold& fold) { return LabelsOf(fold.training) == labels; });
}

}  // namespace

std::vector<std::string> LabelsOf(const ClipSet& clips) {
  std::set<std::string> labels;
  for (const EvalClip* clip : clips) labels.insert(clip->label);
  return {labels.begin(), labels.end()};
}

std::vector<Fold> LeaveOneSourceOut(const ClipSet& clips) {
  std::map<std::string, Fold> folds;
  for (const EvalClip* clip : clips) folds[clip->source].test.push_back(clip);
  std::vector<Fold> all;
  for (auto& [source, fold] : folds) {
    std::copy_if(clips.begin(), clips.end(), std::back_inserter(fold.training),
                 [&](const EvalClip* clip) { return clip->source != source; });
    all.push_back(std::move(fold));
  }
  return all;
}

Folds MakeFolds(const ClipSet& clips) {
  const std::vector<std::string> labels = LabelsOf(clips);
  Folds by_source{"by leaving one subject out", LeaveOneSourceOut(clips), true};
  if (HaveAllLabels(by_source.folds, labels)) return by_source;

  Folds dealt{"by three folds of clips", std::vector<Fold>(kDealtFolds)};
  std::map<std::string, int> seen;
  for (const EvalClip* clip : clips) {
    const int own = seen[clip->label]++ % kDealtFolds;
    for (int f = 0; f < kDealtFolds; ++f) {
      (f == own ? dealt.folds[f].test : dealt.folds[f].training).push_back(clip);
    }
  }
  return dealt;
}

double HeldOutAccuracy(const std::vector<HeldOut>& held_out) {
  int right = 0;
  for (const HeldOut& observation : held_out) {
    right += std::max_element(observation.scores.begin(), observation.scores.end()) -
                 observation.scores.begin() ==
             observation.truth;
  }
  return held_out.empty() ? 0 : static_cast<double>(right) / static_cast<double>(held_out.size());
}

std::vector<double> Softmax(const std::vector<double>& scores, double temperature) {
  const double peak = *std::max_element(scores.begin(), scores.end());
  std::vector<double> probabilities;
  double sum = 0;
  for (const double score : scores) {
    // Scores that are all -infinity give equal probabilities.
    probabilities.push_back(std::isfinite(peak) ? std::exp((score - peak) / temperature) : 1);
    sum += probabilities.back();
  }
  for (double& probability : probabilities) probability /= sum;
  return probabilities;
}

double BestTemperature(const std::vector<HeldOut>& held_out) {
  double best = 1;
  double best_likelihood = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kTemperatures; ++i) {
    const double temperature = std::pow(10, -4 + 8.0 * i / (kTemperatures - 1));
    double likelihood = 0;
    for (const HeldOut& observation : held_out) {
      likelihood +=
          std::log(std::max(Softmax(observation.scores, temperature)[observation.truth], 1e-12));
    }
    if (likelihood > best_likelihood) {
      best_likelihood = likelihood;
      best = temperature;
    }
  }
  return best;
}

}  // namespace motiondb::tests
