// The pages that the server shows over HTTP, on a port of their own: /metrics, /livez, /readyz, and
// / that lists them. The monitor must outlive them.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/observability/http_server.h"
#include "server/observability/log.h"
#include "server/observability/monitor.h"

namespace motiondb::server {

// Where the pages are unless something else is said.
inline constexpr char kDefaultHttpListen[] = "127.0.0.1:9464";

// Starts the pages at `listen`: HOST:PORT; "none" for no pages; empty for 127.0.0.1:9464, where
// they are left out, with a warning, if another program has that port. Null where there are none.
// Warns of an address that others can reach, in the log's format but whatever its level. The
// monitor must outlive the result. Codes: those of HttpServer::Start.
absl::StatusOr<std::unique_ptr<HttpServer>> StartHealthServer(const std::string& listen,
                                                              const Monitor& monitor,
                                                              LogFormat format = LogFormat::kText);

// The monitor must outlive the pages.
HttpPages HealthPages(const Monitor& monitor);

}  // namespace motiondb::server
