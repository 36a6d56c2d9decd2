#include "core/calibration/unknown_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <utility>

#include "core/calibration/unknown_regression.h"

namespace motiondb::core {
namespace {

constexpr double kShrinkageClips = 4;
constexpr std::size_t kMinLabelsForLead = 3;

// The log distances of the known clips.
class KnownDistances {
 public:
  explicit KnownDistances(const std::vector<UnknownSample>& samples) {
    std::map<std::pair<std::size_t, int>, double> samples_of;  // by label and clip
    for (const UnknownSample& sample : samples) {
      if (sample.is_unknown) continue;
      by_label_[sample.label][sample.clip] += sample.own_log_distance;
      ++samples_of[{sample.label, sample.clip}];
    }
    for (auto& [label, clips] : by_label_) {
      double sum = 0;
      for (auto& [clip, distance] : clips) sum += distance /= samples_of[{label, clip}];
      mean_ += sum / static_cast<double>(clips.size() * by_label_.size());
    }
  }

  double mean() const { return mean_; }

  // Returns the mean of a label, without one of its clips (-1: with all).
  double Of(std::size_t label, int without) const {
    const auto found = by_label_.find(label);
    if (found == by_label_.end()) return mean_;
    double count = kShrinkageClips;
    double sum = kShrinkageClips * mean_;
    for (const auto& [clip, distance] : found->second) {
      if (clip == without) continue;
      sum += distance;
      ++count;
    }
    return sum / count;
  }

 private:
  std::map<std::size_t, std::map<int, double>> by_label_;
  double mean_ = 0;
};

}  // namespace

std::optional<UnknownModel> FitUnknownModel(const std::vector<std::string>& labels,
                                            const std::vector<UnknownSample>& samples) {
  const KnownDistances known(samples);
  Eigen::MatrixXd features(samples.size(), UnknownModel::kFeatures);
  std::vector<HeldOutKind> kinds;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const UnknownSample& sample = samples[i];
    const auto of_sample = UnknownFeatures(sample.best, known.Of(sample.best.label, sample.clip));
    for (int f = 0; f < UnknownModel::kFeatures; ++f) {
      features(static_cast<Eigen::Index>(i), f) = of_sample[f];
    }
    kinds.push_back({sample.is_unknown, sample.clip, sample.label});
  }
  // A motion is unknown if it differs more, and known if another label differs much more.
  const auto regression =
      FitUnknownRegression(kinds, features, {1, labels.size() < kMinLabelsForLead ? 0 : -1});
  if (!regression) return std::nullopt;
  UnknownModel model;
  model.intercept = regression->intercept;
  std::ranges::copy(regression->weights, model.weights.begin());
  model.typical_log_distance = known.mean();
  for (std::size_t l = 0; l < labels.size(); ++l) {
    model.labels.push_back({labels[l], known.Of(l, -1)});
  }
  return model;
}

}  // namespace motiondb::core
