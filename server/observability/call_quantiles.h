// How long calls took, in quantiles, from the histogram that metrics show. Pure functions.
#pragma once

#include <prometheus/client_metric.h>

namespace motiondb::server {

// In seconds; all 0 of an empty histogram.
struct CallQuantiles {
  double p50 = 0;
  double p95 = 0;
  double p99 = 0;
};

// The value that a share `quantile` (0 to 1) of the observations does not exceed, linear between
// the bounds of its bucket, the lowest of which begins at 0: what Prometheus' histogram_quantile
// says. Of the last bucket, which has no end, its beginning. 0 of an empty histogram.
double EstimateQuantile(const prometheus::ClientMetric::Histogram& histogram, double quantile);

CallQuantiles EstimateQuantiles(const prometheus::ClientMetric::Histogram& histogram);

}  // namespace motiondb::server
