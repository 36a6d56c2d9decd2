// HTTP pages on a separate port: /metrics, /livez, /readyz, and / with a list of them.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/observability/http_server.h"
#include "server/observability/log.h"
#include "server/observability/monitor.h"

namespace motiondb::server {

// Default address of the pages.
inline constexpr char kDefaultHttpListen[] = "127.0.0.1:9464";

// Serves the pages at `listen`: HOST:PORT; "none" for no pages; empty for 127.0.0.1:9464, or no
// pages and a warning if that port is in use. Returns null if there are no pages. Warns, at any log
// level, if other machines can reach the address. The monitor must outlive the result. Errors:
// those of HttpServer::Start.
absl::StatusOr<std::unique_ptr<HttpServer>> StartHealthServer(const std::string& listen,
                                                              const Monitor& monitor,
                                                              LogFormat format = LogFormat::kText);

// The monitor must outlive the pages.
HttpPages HealthPages(const Monitor& monitor);

}  // namespace motiondb::server
