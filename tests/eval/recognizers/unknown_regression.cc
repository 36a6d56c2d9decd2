#include "tests/eval/recognizers/unknown_regression.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/calibration/recognition_fit.h"

namespace motiondb::tests {
namespace {

constexpr double kOddsBound = 4;
// With two labels, only one remains for an unknown sample: its odds are infinite.
constexpr std::size_t kMinLabelsForOdds = 3;
constexpr double kMissingScore = -std::numeric_limits<double>::infinity();

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

}  // namespace

double UnknownRegression::Probability(const std::vector<double>& scores) const {
  const auto [score, odds] = Features(scores, temperature);
  if (score == kMissingScore) return 1;
  return 1 / (1 + std::exp(-(intercept + score_weight * score + odds_weight * odds)));
}

std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOut>& held_out,
                                                      double temperature) {
  std::vector<core::HeldOutKind> kinds;
  std::vector<std::pair<double, double>> features_of;
  for (const HeldOut& motion : held_out) {
    std::vector<double> scores = motion.scores;
    for (const bool is_unknown : {false, true}) {
      double& own = scores[static_cast<std::size_t>(motion.truth)];
      if (is_unknown) own = kMissingScore;
      if (!is_unknown && own == kMissingScore) continue;
      const auto of_scores = Features(scores, temperature);
      if (of_scores.first == kMissingScore) continue;
      kinds.push_back({is_unknown, motion.clip, static_cast<std::size_t>(motion.truth)});
      features_of.push_back(of_scores);
    }
  }
  Eigen::MatrixXd features(kinds.size(), 2);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    features.row(static_cast<Eigen::Index>(i)) << features_of[i].first, features_of[i].second;
  }
  const std::size_t labels = held_out.empty() ? 0 : held_out.front().scores.size();
  const auto fitted =
      core::FitUnknownRegression(kinds, features, {-1, labels < kMinLabelsForOdds ? 0 : -1});
  if (!fitted) return std::nullopt;
  return UnknownRegression{temperature, fitted->intercept, fitted->weights[0], fitted->weights[1]};
}

}  // namespace motiondb::tests
