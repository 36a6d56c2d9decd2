#include "core/model/prediction_confidence.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

constexpr double kLeast = 1e-4;       // of evidence and errors, before taking logarithms
constexpr double kClampShare = 0.02;  // of samples beyond each clamp
constexpr double kRidge = 1e-3;       // for each sample; evidence may not vary
constexpr double kLeastDeviation = 0.05;

std::array<double, 3> Logs(const PredictionEvidence& evidence) {
  return {std::log(std::max(kLeast, evidence.variance)),
          std::log(std::max(kLeast, evidence.spread)), std::log(std::max(kLeast, evidence.speed))};
}

Eigen::Vector4d Row(const ErrorModel& law, const PredictionEvidence& evidence) {
  const std::array<double, 3> logs = Logs(evidence);
  Eigen::Vector4d row(1, 0, 0, 0);
  for (int i = 0; i < 3; ++i) row[i + 1] = std::clamp(logs[i], law.lowest[i], law.highest[i]);
  return row;
}

ExpectedError JudgeBy(const ErrorModel& law, const PredictionEvidence& evidence, double limit) {
  const double middle =
      Row(law, evidence).dot(Eigen::Map<const Eigen::Vector4d>(law.coefficients.data()));
  const double below = (std::log(limit) - middle) / law.deviation;
  return {std::exp(middle + law.deviation * law.deviation / 2),
          0.5 * std::erfc(-below / std::sqrt(2.0))};
}

}  // namespace

ExpectedError PredictionConfidence::Judge(const PredictionEvidence& evidence, double at_seconds,
                                          double limit) const {
  if (laws.empty()) return {0, std::clamp(1 - evidence.variance, 0.0, 1.0)};
  const auto after = std::lower_bound(
      laws.begin(), laws.end(), at_seconds,
      [](const ErrorModel& law, double seconds) { return law.seconds < seconds - 1e-9; });
  if (after == laws.end()) return JudgeBy(laws.back(), evidence, limit);
  const ExpectedError late = JudgeBy(*after, evidence, limit);
  if (after == laws.begin()) return late;
  const ErrorModel& before = *(after - 1);
  const double share = (at_seconds - before.seconds) / (after->seconds - before.seconds);
  const ExpectedError early = JudgeBy(before, evidence, limit);
  return {early.mean + share * (late.mean - early.mean),
          early.probability + share * (late.probability - early.probability)};
}

ErrorModel FitErrorLaw(double seconds, const std::vector<ErrorSample>& samples) {
  ErrorModel law{.seconds = seconds};
  for (int i = 0; i < 3; ++i) {
    std::vector<double> logs;
    for (const ErrorSample& sample : samples) logs.push_back(Logs(sample.evidence)[i]);
    std::sort(logs.begin(), logs.end());
    const auto cut = static_cast<std::size_t>(kClampShare * static_cast<double>(logs.size()));
    law.lowest[i] = logs[cut];
    law.highest[i] = logs[logs.size() - 1 - cut];
  }
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();
  Eigen::Vector4d products = Eigen::Vector4d::Zero();
  Eigen::Vector4d middle = Eigen::Vector4d::Zero();
  double mean = 0;
  const auto count = static_cast<double>(samples.size());
  for (const ErrorSample& sample : samples) {
    middle += Row(law, sample.evidence) / count;
    mean += std::log(std::max(kLeast, sample.error)) / count;
  }
  middle[0] = 0;
  for (const ErrorSample& sample : samples) {
    const Eigen::Vector4d row = Row(law, sample.evidence) - middle;
    sums += row * row.transpose();
    products += row * (std::log(std::max(kLeast, sample.error)) - mean);
  }
  sums.diagonal().tail<3>().array() += kRidge * count;
  Eigen::Vector4d fitted = sums.llt().solve(products);
  double squares = 0;
  for (const ErrorSample& sample : samples) {
    const double expected = (Row(law, sample.evidence) - middle).dot(fitted) + mean;
    squares += std::pow(std::log(std::max(kLeast, sample.error)) - expected, 2);
  }
  law.deviation = std::max(kLeastDeviation, std::sqrt(squares / std::max(1.0, count - 4)));
  fitted[0] += mean - fitted.tail<3>().dot(middle.tail<3>());
  std::copy(fitted.begin(), fitted.end(), law.coefficients.begin());
  // With every clip held back nothing is as well known as what is stored: there the law goes on.
  if (fitted[1] > 0) law.lowest[0] = std::log(kLeast);
  return law;
}

}  // namespace motiondb::core
