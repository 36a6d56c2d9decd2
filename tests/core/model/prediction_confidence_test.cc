#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/model/answer_calibration.h"

namespace motiondb::tests::prediction_confidence_test {
namespace {

// Returns samples with errors of a known error model.
std::vector<core::ErrorSample> Samples(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<core::ErrorSample> samples;
  for (int i = 0; i < count; ++i) {
    core::PredictionEvidence evidence{std::exp(-2 + 0.5 * normal(random)),
                                      std::exp(-3 + 0.4 * normal(random)),
                                      std::exp(-3 + 0.7 * normal(random))};
    const double log_error = -2 + 0.8 * std::log(evidence.variance) +
                             0.3 * std::log(evidence.spread) + 0.25 * normal(random);
    samples.push_back({evidence, std::exp(log_error)});
  }
  return samples;
}

}  // namespace

TEST_CASE("PredictionConfidence: a fitted error model is calibrated on new samples",
          "[core][model]") {
  core::PredictionConfidence confidence{{core::FitErrorModel(0.4, Samples(200, 1))}};
  const auto tests = Samples(4000, 2);
  double sum_of_probabilities = 0;
  double sum_of_means = 0;
  double sum_of_errors = 0;
  int below = 0;
  double deviation[10] = {};
  for (const core::ErrorSample& test : tests) {
    const core::ExpectedError estimate = confidence.Judge(test.evidence, 0.4, 0.01);
    sum_of_probabilities += estimate.probability;
    sum_of_means += estimate.mean;
    sum_of_errors += test.error;
    const bool is_below = test.error < 0.01;
    below += is_below;
    deviation[std::min(9, static_cast<int>(10 * estimate.probability))] +=
        estimate.probability - is_below;
  }
  CHECK(sum_of_means / sum_of_errors == Approx(1).margin(0.1));
  CHECK(sum_of_probabilities / below == Approx(1).margin(0.1));
  double calibration_error = 0;
  for (const double bin : deviation) calibration_error += std::abs(bin) / 4000;
  CHECK(calibration_error < 0.05);
}

TEST_CASE("PredictionConfidence: interpolates between horizons; uses the variance without models",
          "[core][model]") {
  const core::ErrorModel early = core::FitErrorModel(0.2, Samples(100, 1));
  auto later = Samples(100, 3);
  for (core::ErrorSample& sample : later) sample.error *= 3;
  const core::PredictionConfidence confidence{{early, core::FitErrorModel(0.4, later)}};
  const core::PredictionEvidence evidence{0.1, 0.05, 0.05};
  const double middle = confidence.Judge(evidence, 0.3, 0.01).mean;
  CHECK(middle == Approx((confidence.Judge(evidence, 0.2, 0.01).mean +
                          confidence.Judge(evidence, 0.4, 0.01).mean) /
                         2));
  CHECK(confidence.Judge(evidence, 0.05, 0.01).mean == confidence.Judge(evidence, 0.2, 0.01).mean);
  CHECK(confidence.Judge(evidence, 5, 0.01).mean == confidence.Judge(evidence, 0.4, 0.01).mean);
  CHECK_FALSE(confidence.IsBeyond(0.4));
  CHECK(confidence.IsBeyond(0.41));
  CHECK_FALSE(core::PredictionConfidence().IsBeyond(5));
  const core::ExpectedError unknown = core::PredictionConfidence().Judge(evidence, 0.3, 0.01);
  CHECK(unknown.mean == 0);
  CHECK(unknown.probability == Approx(0.9));
}

TEST_CASE("FitErrorModel: extrapolates to a smaller variance than that of any sample",
          "[core][model]") {
  const core::PredictionConfidence confidence{{core::FitErrorModel(0.4, Samples(200, 1))}};
  const double error_at_small_variance = confidence.Judge({0.02, 0.05, 0.05}, 0.4, 0.01).mean;
  const double error_at_smaller_variance = confidence.Judge({0.002, 0.05, 0.05}, 0.4, 0.01).mean;
  CHECK(error_at_smaller_variance < 0.3 * error_at_small_variance);
  // Both speeds are below those of all samples, so they are clamped to the same value.
  CHECK(confidence.Judge({0.02, 0.05, 1e-4}, 0.4, 0.01).mean ==
        confidence.Judge({0.02, 0.05, 2e-4}, 0.4, 0.01).mean);
}

TEST_CASE("FitErrorModel: accepts constant evidence", "[core][model]") {
  const std::vector<core::ErrorSample> constant_samples(20, {{0.5, 0, 0}, 0.02});
  const core::PredictionConfidence confidence{{core::FitErrorModel(0.4, constant_samples)}};
  const core::ExpectedError estimate = confidence.Judge({0.5, 0, 0}, 0.4, 0.1);
  CHECK(estimate.mean == Approx(0.02).epsilon(0.05));
  CHECK(estimate.probability > 0.99);
}

}  // namespace motiondb::tests::prediction_confidence_test
