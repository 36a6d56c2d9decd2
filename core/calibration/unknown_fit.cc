#include "core/calibration/unknown_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/calibration/unknown_regression.h"

namespace motiondb::core {
namespace {

constexpr double kShrinkageClips = 4;
constexpr double kMinDeviation = 1e-6;
constexpr std::size_t kMinLabelsForLead = 3;

// The fits of the known clips.
class KnownFits {
 public:
  explicit KnownFits(const std::vector<UnknownSample>& samples) {
    std::map<std::pair<std::size_t, int>, double> samples_of;  // by label and clip
    for (const UnknownSample& sample : samples) {
      if (sample.is_unknown) continue;
      by_label_[sample.label][sample.clip] += sample.own_fit;
      ++samples_of[{sample.label, sample.clip}];
    }
    for (auto& [label, clips] : by_label_) {
      double sum = 0;
      for (auto& [clip, fit] : clips) sum += fit /= samples_of[{label, clip}];
      const double mean = sum / static_cast<double>(clips.size());
      mean_of_label_[label] = mean;
      mean_ += mean / static_cast<double>(by_label_.size());
    }
    double squares = 0;
    double count = 0;
    for (const UnknownSample& sample : samples) {
      if (sample.is_unknown) continue;
      squares += std::pow(sample.own_fit - mean_of_label_[sample.label], 2);
      ++count;
    }
    deviation_ = std::max(kMinDeviation, std::sqrt(squares / std::max(1.0, count)));
  }

  double mean() const { return mean_; }
  double deviation() const { return deviation_; }

  // Returns the mean and the deviation of a label, without one of its clips (-1: with all).
  std::pair<double, double> Of(std::size_t label, int without) const {
    const auto found = by_label_.find(label);
    double count = kShrinkageClips;
    double sum = kShrinkageClips * mean_;
    double squares = kShrinkageClips * deviation_ * deviation_;
    if (found == by_label_.end()) return {mean_, deviation_};
    for (const auto& [clip, fit] : found->second) {
      if (clip == without) continue;
      sum += fit;
      ++count;
    }
    const double mean = sum / count;
    for (const auto& [clip, fit] : found->second) {
      if (clip != without) squares += (fit - mean) * (fit - mean);
    }
    return {mean, std::sqrt(squares / count)};
  }

 private:
  std::map<std::size_t, std::map<int, double>> by_label_;
  std::map<std::size_t, double> mean_of_label_;
  double mean_ = 0;
  double deviation_ = 1;
};

}  // namespace

std::optional<UnknownModel> FitUnknownModel(const std::vector<std::string>& labels,
                                            const std::vector<UnknownSample>& samples) {
  const KnownFits fits(samples);
  Eigen::MatrixXd features(samples.size(), UnknownModel::kFeatures);
  std::vector<HeldOutKind> kinds;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const UnknownSample& sample = samples[i];
    const auto [mean, deviation] = fits.Of(sample.best.label, sample.clip);
    const auto of_sample = UnknownFeatures(sample.best, mean, deviation);
    for (int f = 0; f < UnknownModel::kFeatures; ++f) {
      features(static_cast<Eigen::Index>(i), f) = of_sample[f];
    }
    kinds.push_back({sample.is_unknown, sample.clip, sample.label});
  }
  // A better fit and a larger lead make a motion known.
  const auto regression =
      FitUnknownRegression(kinds, features, {-1, labels.size() < kMinLabelsForLead ? 0 : -1});
  if (!regression) return std::nullopt;
  UnknownModel model;
  model.intercept = regression->intercept;
  std::ranges::copy(regression->weights, model.weights.begin());
  model.typical_mean = fits.mean();
  model.typical_deviation = fits.deviation();
  for (std::size_t l = 0; l < labels.size(); ++l) {
    const auto [mean, deviation] = fits.Of(l, -1);
    model.fits.push_back({labels[l], mean, deviation});
  }
  return model;
}

}  // namespace motiondb::core
