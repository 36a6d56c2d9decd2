// Compares quantiles of a histogram with the sorted observations.
#include <prometheus/histogram.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "server/observability/call_meter.h"

namespace motiondb::tests::call_quantiles_test {
namespace {

using server::EstimateQuantile;

const std::vector<double> kBounds{0.001, 0.01, 0.1, 1};

prometheus::ClientMetric::Histogram HistogramOf(const std::vector<double>& values) {
  prometheus::Histogram histogram(kBounds);
  for (const double value : values) histogram.Observe(value);
  return histogram.Collect().histogram;
}

TEST_CASE("EstimateQuantile: linear within a bucket", "[server][monitor]") {
  const auto histogram = HistogramOf({0.005, 0.005, 0.05, 0.05});
  CHECK(EstimateQuantile(histogram, 0.25) == Approx(0.0055));
  CHECK(EstimateQuantile(histogram, 0.5) == Approx(0.01));
  CHECK(EstimateQuantile(histogram, 0.75) == Approx(0.055));
  CHECK(EstimateQuantile(histogram, 1) == Approx(0.1));
}

TEST_CASE("EstimateQuantile: no observation, and one beyond the last bound", "[server][monitor]") {
  CHECK(EstimateQuantile(HistogramOf({}), 0.5) == 0);
  CHECK(EstimateQuantile(prometheus::ClientMetric::Histogram(), 0.5) == 0);
  CHECK(EstimateQuantile(HistogramOf({5, 50, 500}), 0.5) == 1);
  CHECK(EstimateQuantile(HistogramOf({0.0005}), 0) == 0);
}

TEST_CASE("EstimateQuantile: is in the bucket of the true quantile", "[server][monitor]") {
  std::mt19937 random(6);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> values(std::uniform_int_distribution(1, 300)(random));
    std::lognormal_distribution<double> draw(-4, 2);
    for (double& value : values) value = draw(random);
    const auto histogram = HistogramOf(values);
    std::sort(values.begin(), values.end());
    const auto bucket_of = [](double value) {
      return std::lower_bound(kBounds.begin(), kBounds.end(), value) - kBounds.begin();
    };
    for (const double quantile : {0.5, 0.95, 0.99}) {
      const double rank = std::ceil(quantile * static_cast<double>(values.size()));
      const double exact = values[static_cast<std::size_t>(rank) - 1];
      const double estimate = EstimateQuantile(histogram, quantile);
      CAPTURE(round, quantile, exact, estimate);
      if (exact > kBounds.back()) {
        CHECK(estimate == kBounds.back());
      } else {
        CHECK(bucket_of(estimate) == bucket_of(exact));
      }
    }
    const auto all = server::EstimateQuantiles(histogram);
    CHECK(all.p50 == EstimateQuantile(histogram, 0.5));
    CHECK(all.p95 == EstimateQuantile(histogram, 0.95));
    CHECK(all.p99 == EstimateQuantile(histogram, 0.99));
  }
}

}  // namespace
}  // namespace motiondb::tests::call_quantiles_test
