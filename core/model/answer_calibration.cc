#include "core/model/answer_calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

constexpr double kMinValue = 1e-4;    // of evidence and errors, before the logarithm
constexpr double kClampShare = 0.02;  // share of samples beyond each clamp
constexpr double kRidge = 1e-3;       // for each sample; the evidence may be constant
constexpr double kMinDeviation = 0.05;

std::array<double, 3> Logs(const PredictionEvidence& evidence) {
  return {std::log(std::max(kMinValue, evidence.variance)),
          std::log(std::max(kMinValue, evidence.spread)),
          std::log(std::max(kMinValue, evidence.speed))};
}

Eigen::Vector4d Row(const ErrorModel& model, const PredictionEvidence& evidence) {
  const std::array<double, 3> logs = Logs(evidence);
  Eigen::Vector4d row(1, 0, 0, 0);
  for (int i = 0; i < 3; ++i) row[i + 1] = std::clamp(logs[i], model.lowest[i], model.highest[i]);
  return row;
}

ExpectedError EstimateError(const ErrorModel& model, const PredictionEvidence& evidence,
                            double limit) {
  const double middle =
      Row(model, evidence).dot(Eigen::Map<const Eigen::Vector4d>(model.coefficients.data()));
  const double below = (std::log(limit) - middle) / model.deviation;
  return {std::exp(middle + model.deviation * model.deviation / 2),
          0.5 * std::erfc(-below / std::sqrt(2.0))};
}

}  // namespace

bool PredictionConfidence::IsBeyond(double seconds) const {
  return !models.empty() && seconds > models.back().seconds + 1e-6;
}

ExpectedError PredictionConfidence::Judge(const PredictionEvidence& evidence, double at_seconds,
                                          double limit) const {
  if (models.empty()) return {0, std::clamp(1 - evidence.variance, 0.0, 1.0)};
  const auto after = std::lower_bound(
      models.begin(), models.end(), at_seconds,
      [](const ErrorModel& model, double seconds) { return model.seconds < seconds - 1e-9; });
  if (after == models.end()) return EstimateError(models.back(), evidence, limit);
  const ExpectedError late = EstimateError(*after, evidence, limit);
  if (after == models.begin()) return late;
  const ErrorModel& before = *(after - 1);
  const double share = (at_seconds - before.seconds) / (after->seconds - before.seconds);
  const ExpectedError early = EstimateError(before, evidence, limit);
  return {early.mean + share * (late.mean - early.mean),
          early.probability + share * (late.probability - early.probability)};
}

ErrorModel FitErrorModel(double seconds, const std::vector<ErrorSample>& samples) {
  ErrorModel model{.seconds = seconds};
  for (int i = 0; i < 3; ++i) {
    std::vector<double> logs;
    logs.reserve(samples.size());
    for (const ErrorSample& sample : samples) logs.push_back(Logs(sample.evidence)[i]);
    std::sort(logs.begin(), logs.end());
    const auto cut = static_cast<std::size_t>(kClampShare * static_cast<double>(logs.size()));
    model.lowest[i] = logs[cut];
    model.highest[i] = logs[logs.size() - 1 - cut];
  }
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();
  Eigen::Vector4d products = Eigen::Vector4d::Zero();
  Eigen::Vector4d middle = Eigen::Vector4d::Zero();
  double mean = 0;
  const auto count = static_cast<double>(samples.size());
  for (const ErrorSample& sample : samples) {
    middle += Row(model, sample.evidence) / count;
    mean += std::log(std::max(kMinValue, sample.error)) / count;
  }
  middle[0] = 0;
  for (const ErrorSample& sample : samples) {
    const Eigen::Vector4d row = Row(model, sample.evidence) - middle;
    sums += row * row.transpose();
    products += row * (std::log(std::max(kMinValue, sample.error)) - mean);
  }
  sums.diagonal().tail<3>().array() += kRidge * count;
  Eigen::Vector4d fitted = sums.llt().solve(products);
  double squares = 0;
  for (const ErrorSample& sample : samples) {
    const double expected = (Row(model, sample.evidence) - middle).dot(fitted) + mean;
    squares += std::pow(std::log(std::max(kMinValue, sample.error)) - expected, 2);
  }
  model.deviation = std::max(kMinDeviation, std::sqrt(squares / std::max(1.0, count - 4)));
  fitted[0] += mean - fitted.tail<3>().dot(middle.tail<3>());
  std::copy(fitted.begin(), fitted.end(), model.coefficients.begin());
  // Held-out clips have larger variances than stored ones, so the model extrapolates to smaller
  // ones.
  if (fitted[1] > 0) model.lowest[0] = std::log(kMinValue);
  return model;
}

}  // namespace motiondb::core
