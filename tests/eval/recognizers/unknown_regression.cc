#include "tests/eval/recognizers/unknown_regression.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace motiondb::tests {
namespace {

constexpr double kOddsBound = 4;
constexpr double kRidge = 0.1;
constexpr std::size_t kMinClips = 4;
constexpr std::size_t kMinLabels = 2;
// With two labels, only one remains for an unknown sample: its odds are infinite.
constexpr std::size_t kMinLabelsForOdds = 3;
constexpr double kMissingScore = -std::numeric_limits<double>::infinity();

// Intercept, score and odds.
using Coefficients = Eigen::Vector3d;

struct Sample {
  bool is_unknown = false;
  int label = 0;
  int clip = 0;
  double score = 0;
  double odds = 0;
};

// Returns the best score and the bounded log odds. Labels without a score are left out.
std::pair<double, double> Features(const std::vector<double>& scores, double temperature) {
  const auto best = std::ranges::max_element(scores);
  double others = 0;
  for (auto score = scores.begin(); score != scores.end(); ++score) {
    if (score != best) others += std::exp((*score - *best) / temperature);
  }
  if (others == 0) return {*best, kOddsBound};
  const double log_odds = -std::log(others);
  return {*best, log_odds / (1 + std::abs(log_odds) / kOddsBound)};
}

std::vector<Sample> MakeSamples(const std::vector<HeldOut>& held_out, double temperature) {
  std::vector<Sample> samples;
  for (const HeldOut& motion : held_out) {
    std::vector<double> scores = motion.scores;
    for (const bool is_unknown : {false, true}) {
      double& own = scores[static_cast<std::size_t>(motion.truth)];
      if (is_unknown) own = kMissingScore;
      if (!is_unknown && own == kMissingScore) continue;
      const auto [score, odds] = Features(scores, temperature);
      if (score == kMissingScore) continue;
      samples.push_back({is_unknown, motion.truth, motion.clip, score, odds});
    }
  }
  return samples;
}

bool AreEnoughClips(const std::vector<Sample>& samples, bool is_unknown) {
  std::set<int> clips;
  std::set<int> labels;
  for (const Sample& sample : samples) {
    if (sample.is_unknown != is_unknown) continue;
    clips.insert(sample.clip);
    labels.insert(sample.label);
  }
  return clips.size() >= kMinClips && labels.size() >= kMinLabels;
}

// Returns weights that sum to 1.
Eigen::VectorXd WeightsOf(const std::vector<Sample>& samples, double label_count) {
  std::map<std::pair<bool, int>, double> samples_of;
  for (const Sample& sample : samples) ++samples_of[{sample.is_unknown, sample.label}];
  std::array<double, 2> labels{};
  for (const auto& [kind, count] : samples_of) ++labels[kind.first];
  Eigen::VectorXd weights(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool is_unknown = samples[i].is_unknown;
    const double share = (is_unknown ? 1 : label_count) / (1 + label_count);
    weights[static_cast<Eigen::Index>(i)] =
        share / (labels[is_unknown] * samples_of[{is_unknown, samples[i].label}]);
  }
  return weights;
}

// Minimizes the weighted logistic loss plus the ridge, by Newton's method. Columns of `design` that
// are 0 get the coefficient 0.
Coefficients MinimizeLoss(const Eigen::MatrixX3d& design, const Eigen::VectorXd& is_unknown,
                          const Eigen::VectorXd& weights, double ridge) {
  constexpr int kMaxSteps = 50;
  constexpr double kMinStep = 1e-9;
  const Coefficients penalty(0, ridge, ridge);
  Coefficients b = Coefficients::Zero();
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::ArrayXd p = 1 / (1 + (-(design * b).array().max(-30).min(30)).exp());
    const Coefficients gradient =
        design.transpose() * (weights.array() * (p - is_unknown.array())).matrix() +
        penalty.cwiseProduct(b);
    const Eigen::VectorXd curvature = weights.array() * p * (1 - p) + 1e-12;
    Eigen::Matrix3d hessian = design.transpose() * curvature.asDiagonal() * design;
    hessian.diagonal() += penalty;
    const Coefficients change = hessian.ldlt().solve(gradient);
    b -= change;
    if (change.cwiseAbs().maxCoeff() < kMinStep) break;
  }
  return b;
}

}  // namespace

double UnknownRegression::Probability(const std::vector<double>& scores) const {
  const auto [score, odds] = Features(scores, temperature);
  if (score == kMissingScore) return 1;
  return 1 / (1 + std::exp(-(intercept + score_weight * score + odds_weight * odds)));
}

std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOut>& held_out,
                                                      double temperature) {
  const std::vector<Sample> samples = MakeSamples(held_out, temperature);
  if (!AreEnoughClips(samples, false) || !AreEnoughClips(samples, true)) return std::nullopt;
  const std::size_t label_count = held_out.front().scores.size();
  Eigen::MatrixX3d design(samples.size(), 3);
  Eigen::VectorXd is_unknown(samples.size());
  std::set<int> clips;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    design.row(row) << 1, samples[i].score, samples[i].odds;
    is_unknown[row] = samples[i].is_unknown ? 1 : 0;
    clips.insert(samples[i].clip);
  }
  Coefficients center = Coefficients::Zero();
  Coefficients spread = Coefficients::Ones();
  for (int f = 1; f < 3; ++f) {
    center[f] = design.col(f).mean();
    spread[f] = std::max(1e-6, std::sqrt((design.col(f).array() - center[f]).square().mean()));
    design.col(f) = (design.col(f).array() - center[f]) / spread[f];
  }
  if (label_count < kMinLabelsForOdds) design.col(2).setZero();
  const Eigen::VectorXd weights = WeightsOf(samples, static_cast<double>(label_count));
  const double ridge = kRidge / static_cast<double>(clips.size());
  Coefficients b = MinimizeLoss(design, is_unknown, weights, ridge);
  while (b[1] > 0 || b[2] > 0) {
    for (int f = 1; f < 3; ++f) {
      if (b[f] > 0) design.col(f).setZero();
    }
    b = MinimizeLoss(design, is_unknown, weights, ridge);
  }
  const Coefficients raw = b.cwiseQuotient(spread);
  return UnknownRegression{temperature, raw[0] - raw.tail<2>().dot(center.tail<2>()), raw[1],
                           raw[2]};
}

}  // namespace motiondb::tests
