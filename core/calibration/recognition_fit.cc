#include "core/calibration/recognition_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/recognition/unknown.h"

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

namespace {

constexpr std::size_t kMinClips = 4;
constexpr std::size_t kMinLabels = 2;
constexpr double kRidge = 0.1;
constexpr double kMinSpread = 1e-6;

bool AreEnough(const std::vector<HeldOutKind>& kinds, bool is_unknown) {
  std::set<int> clips;
  std::set<std::size_t> labels;
  for (const HeldOutKind& kind : kinds) {
    if (kind.is_unknown != is_unknown) continue;
    clips.insert(kind.clip);
    labels.insert(kind.label);
  }
  return clips.size() >= kMinClips && labels.size() >= kMinLabels;
}

// Weights that sum to 1.
Eigen::VectorXd SampleWeights(const std::vector<HeldOutKind>& kinds) {
  std::map<std::pair<bool, std::size_t>, double> samples_of;
  for (const HeldOutKind& kind : kinds) ++samples_of[{kind.is_unknown, kind.label}];
  std::array<double, 2> labels{};
  for (const auto& [kind, count] : samples_of) ++labels[kind.first];
  Eigen::VectorXd weights(kinds.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const bool is_unknown = kinds[i].is_unknown;
    const double share = is_unknown ? kUnknownShare : 1 - kUnknownShare;
    weights[static_cast<Eigen::Index>(i)] =
        share / (labels[is_unknown] * samples_of[{is_unknown, kinds[i].label}]);
  }
  return weights;
}

// Minimizes the weighted logistic loss plus the ridge. The first column of `design` is 1; columns
// that are 0 get the coefficient 0.
Eigen::VectorXd MinimizeLoss(const Eigen::MatrixXd& design, const Eigen::VectorXd& is_unknown,
                             const Eigen::VectorXd& weights, double ridge) {
  constexpr int kMaxSteps = 50;
  constexpr double kMinStep = 1e-9;
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(design.cols(), ridge);
  penalty[0] = 0;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(design.cols());
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

std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOutKind>& kinds,
                                                      const Eigen::MatrixXd& features,
                                                      std::vector<int> signs) {
  if (!AreEnough(kinds, false) || !AreEnough(kinds, true)) return std::nullopt;
  Eigen::VectorXd is_unknown(kinds.size());
  std::set<int> clips;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    is_unknown[static_cast<Eigen::Index>(i)] = kinds[i].is_unknown ? 1 : 0;
    clips.insert(kinds[i].clip);
  }
  const Eigen::Index count = features.cols();
  const Eigen::RowVectorXd center = features.colwise().mean();
  Eigen::MatrixXd design(features.rows(), count + 1);
  design.col(0).setOnes();
  design.rightCols(count) = features.rowwise() - center;
  const Eigen::RowVectorXd spread =
      design.rightCols(count).array().square().colwise().mean().sqrt().max(kMinSpread);
  design.rightCols(count).array().rowwise() /= spread.array();

  const Eigen::VectorXd weights = SampleWeights(kinds);
  const double ridge = kRidge / static_cast<double>(clips.size());
  Eigen::VectorXd b;
  for (bool has_wrong_sign = true; has_wrong_sign;) {
    for (Eigen::Index f = 0; f < count; ++f) {
      if (signs[static_cast<std::size_t>(f)] == 0) design.col(f + 1).setZero();
    }
    b = MinimizeLoss(design, is_unknown, weights, ridge);
    has_wrong_sign = false;
    for (Eigen::Index f = 0; f < count; ++f) {
      int& sign = signs[static_cast<std::size_t>(f)];
      if (b[f + 1] * sign >= 0) continue;
      sign = 0;
      has_wrong_sign = true;
    }
  }
  const Eigen::VectorXd raw = b.tail(count).cwiseQuotient(spread.transpose());
  return UnknownRegression{b[0] - center.dot(raw), raw};
}

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
