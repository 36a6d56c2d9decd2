// Metrics of the store, and of the server's part in a store that several servers share.
#pragma once

#include "server/observability/metric_families.h"
#include "server/observability/server_statistics.h"

namespace motiondb::server {

void AddStore(const ServerStatistics& statistics, MetricFamilies& families);

}  // namespace motiondb::server
