// The pages that the server shows over HTTP: /metrics, /livez, /readyz, and / that lists them.
#pragma once

#include "server/observability/http_server.h"
#include "server/observability/monitor.h"

namespace motiondb::server {

// The monitor must outlive the pages.
HttpPages HealthPages(const Monitor& monitor);

}  // namespace motiondb::server
