#include "core/calibration/unknown_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace motiondb::core {
namespace {

constexpr std::size_t kMinClips = 4;
constexpr std::size_t kMinLabels = 2;
constexpr double kShrinkageClips = 4;
constexpr double kRidge = 0.1;
constexpr double kMinDeviation = 1e-6;
constexpr int kFeatures = UnknownModel::kFeatures;
// An unexplained motion is unknown; a better fit or higher odds make it known.
constexpr std::array<double, kFeatures> kSigns = {1, -1, -1};
constexpr std::size_t kMinLabelsForOdds = 3;

using Features = Eigen::Matrix<double, Eigen::Dynamic, kFeatures>;

bool AreEnough(const std::vector<UnknownSample>& samples, bool is_unknown) {
  std::set<int> clips;
  std::set<std::size_t> labels;
  for (const UnknownSample& sample : samples) {
    if (sample.is_unknown != is_unknown) continue;
    clips.insert(sample.clip);
    labels.insert(sample.label);
  }
  return clips.size() >= kMinClips && labels.size() >= kMinLabels;
}

// The fits of the known clips.
class KnownFits {
 public:
  explicit KnownFits(const std::vector<UnknownSample>& samples) {
    std::map<int, double> samples_of;
    for (const UnknownSample& sample : samples) {
      if (sample.is_unknown) continue;
      by_label_[sample.label][sample.clip] += sample.own_fit;
      ++samples_of[sample.clip];
    }
    for (auto& [label, clips] : by_label_) {
      double sum = 0;
      for (auto& [clip, fit] : clips) sum += fit /= samples_of[clip];
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
    deviation_ = std::max(kMinDeviation, std::sqrt(squares / count));
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

// Weights that sum to 1. Labels count equally; unknown samples count as one label.
Eigen::VectorXd SampleWeights(const std::vector<UnknownSample>& samples) {
  std::map<std::pair<bool, std::size_t>, double> samples_of;
  for (const UnknownSample& sample : samples) ++samples_of[{sample.is_unknown, sample.label}];
  std::array<double, 2> labels{};
  for (const auto& [kind, count] : samples_of) ++labels[kind.first];
  Eigen::VectorXd weights(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool is_unknown = samples[i].is_unknown;
    const double share = (is_unknown ? 1 : labels[0]) / (1 + labels[0]);
    weights[static_cast<Eigen::Index>(i)] =
        share / (labels[is_unknown] * samples_of[{is_unknown, samples[i].label}]);
  }
  return weights;
}

// Fits P(unknown) = 1 / (1 + exp(-(b0 + sum of b_i x_i))) by Newton's method. The weights of unused
// features are 0.
Eigen::VectorXd FitLogistic(const Features& features, const Eigen::VectorXd& is_unknown,
                            const Eigen::VectorXd& weights, double ridge,
                            const std::array<bool, kFeatures>& used) {
  constexpr int kMaxSteps = 50;
  constexpr double kMinStep = 1e-9;
  Eigen::MatrixXd design(features.rows(), kFeatures + 1);
  design.col(0).setOnes();
  for (int f = 0; f < kFeatures; ++f) {
    if (used[f]) {
      design.col(f + 1) = features.col(f);
    } else {
      design.col(f + 1).setZero();
    }
  }
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(kFeatures + 1, ridge);
  penalty[0] = 0;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(kFeatures + 1);
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::ArrayXd p = 1 / (1 + (-(design * b).array().max(-30).min(30)).exp());
    const Eigen::VectorXd gradient =
        design.transpose() * (weights.array() * (p - is_unknown.array())).matrix() +
        penalty.cwiseProduct(b);
    const Eigen::VectorXd curvature = weights.array() * p * (1 - p) + 1e-12;
    Eigen::MatrixXd hessian = design.transpose() * curvature.asDiagonal() * design;
    hessian.diagonal() += penalty;
    const Eigen::VectorXd change = hessian.ldlt().solve(gradient);
    b -= change;
    if (change.cwiseAbs().maxCoeff() < kMinStep) break;
  }
  return b;
}

}  // namespace

std::optional<UnknownModel> FitUnknownModel(const std::vector<std::string>& labels,
                                            const std::vector<UnknownSample>& samples) {
  if (!AreEnough(samples, false) || !AreEnough(samples, true)) return std::nullopt;
  const KnownFits fits(samples);
  Features features(samples.size(), kFeatures);
  Eigen::VectorXd is_unknown(samples.size());
  std::set<int> clips;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const UnknownSample& sample = samples[i];
    const auto [mean, deviation] = fits.Of(sample.best.label, sample.clip);
    const auto of_sample = UnknownFeatures(sample.best, mean, deviation);
    for (int f = 0; f < kFeatures; ++f) features(static_cast<Eigen::Index>(i), f) = of_sample[f];
    is_unknown[static_cast<Eigen::Index>(i)] = sample.is_unknown ? 1 : 0;
    clips.insert(sample.clip);
  }
  const Eigen::VectorXd weights = SampleWeights(samples);
  Eigen::RowVectorXd center(kFeatures);
  Eigen::RowVectorXd spread(kFeatures);
  for (int f = 0; f < kFeatures; ++f) {
    center[f] = features.col(f).mean();
    spread[f] =
        std::max(kMinDeviation, std::sqrt((features.col(f).array() - center[f]).square().mean()));
    features.col(f) = (features.col(f).array() - center[f]) / spread[f];
  }
  std::array<bool, kFeatures> used = {true, true, labels.size() >= kMinLabelsForOdds};
  Eigen::VectorXd b;
  for (bool has_wrong_sign = true; has_wrong_sign;) {
    b = FitLogistic(features, is_unknown, weights, kRidge / static_cast<double>(clips.size()),
                    used);
    has_wrong_sign = false;
    for (int f = 0; f < kFeatures; ++f) {
      if (!used[f] || b[f + 1] * kSigns[f] >= 0) continue;
      used[f] = false;
      has_wrong_sign = true;
    }
  }
  UnknownModel model;
  model.intercept = b[0];
  for (int f = 0; f < kFeatures; ++f) {
    model.weights[f] = b[f + 1] / spread[f];
    model.intercept -= model.weights[f] * center[f];
  }
  model.typical_mean = fits.mean();
  model.typical_deviation = fits.deviation();
  for (std::size_t l = 0; l < labels.size(); ++l) {
    const auto [mean, deviation] = fits.Of(l, -1);
    model.fits.push_back({labels[l], mean, deviation});
  }
  return model;
}

}  // namespace motiondb::core
