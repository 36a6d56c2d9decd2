// HTTP pages on a separate port: /metrics, /livez, /readyz, and / with a list of them.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/observability/log.h"
#include "server/observability/monitor.h"

namespace motiondb::server {

struct HttpAnswer {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body;
};

struct HttpPage {
  std::function<HttpAnswer()> make;  // must not throw; called by one thread at a time
  bool is_immediate = false;         // immediate page: made without waiting for other pages
};

using HttpPages = std::map<std::string, HttpPage, std::less<>>;  // by path, "/metrics"

struct HttpLimits {
  int connections = 64;
  std::chrono::milliseconds request_time{5000};   // to receive a request, idle time included
  std::chrono::milliseconds answer_time{10'000};  // to send a response
};

// A small HTTP/1.1 server for metrics and health pages: GET and HEAD only, no authentication.
// Thread-safe; owns its socket and two threads, one for sockets and one that makes pages.
//
// Bounds: the size of a request, the time to receive it and to send the response, and the number of
// connections (Listener). So slow or faulty clients do not lock out others.
// A slow page is made once for all requests that arrive meanwhile. At most half of the connections
// may wait for slow pages, a quarter from one address; further requests get 503. So immediate pages
// are always served.
class HttpServer {
 public:
  // Listens at HOST:PORT and serves the pages; port 0 selects a free port. Errors: those of
  // ListenOn.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           HttpPages pages, HttpLimits limits = {});
  // Closes all connections. Waits for a page that is being made.
  virtual ~HttpServer() = default;

  // HOST:PORT for clients.
  virtual const std::string& address() const = 0;
  // True if only this machine can reach it.
  virtual bool is_loopback() const = 0;
};

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
