#include "server/observability/call_quantiles.h"

#include <algorithm>
#include <cmath>

namespace motiondb::server {

double EstimateQuantile(const prometheus::ClientMetric::Histogram& histogram, double quantile) {
  if (histogram.sample_count == 0) return 0;
  const double rank = quantile * static_cast<double>(histogram.sample_count);
  const auto& buckets = histogram.bucket;
  const auto bucket = std::find_if(buckets.begin(), buckets.end(), [&](const auto& candidate) {
    return static_cast<double>(candidate.cumulative_count) >= rank;
  });
  double begin = 0, before = 0;
  if (bucket != buckets.begin()) {
    begin = std::prev(bucket)->upper_bound;
    before = static_cast<double>(std::prev(bucket)->cumulative_count);
  }
  if (bucket == buckets.end() || std::isinf(bucket->upper_bound)) return begin;
  const double inside = static_cast<double>(bucket->cumulative_count) - before;
  const double share = inside > 0 ? (rank - before) / inside : 0;
  return std::lerp(begin, bucket->upper_bound, share);
}

CallQuantiles EstimateQuantiles(const prometheus::ClientMetric::Histogram& histogram) {
  return {.p50 = EstimateQuantile(histogram, 0.50),
          .p95 = EstimateQuantile(histogram, 0.95),
          .p99 = EstimateQuantile(histogram, 0.99)};
}

}  // namespace motiondb::server
