// The server's figures as Prometheus metrics. server/observability/README.md lists them all.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "server/observability/server_figures.h"

namespace motiondb::server {

// A database that is gone has no series.
std::vector<prometheus::MetricFamily> FamiliesOf(const ServerFigures& figures);

}  // namespace motiondb::server
