#include "server/observability/health_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

#include "server/engine/work/memory_reserve.h"
#include "server/observability/log.h"

namespace motiondb::server {

absl::StatusOr<std::unique_ptr<HttpServer>> StartHealthServer(const std::string& listen,
                                                              const Monitor& monitor,
                                                              LogFormat format) {
  if (listen == "none") return nullptr;
  const bool is_explicit = !listen.empty();
  auto server = HttpServer::Start(is_explicit ? listen : kDefaultHttpListen, HealthPages(monitor));
  if (!is_explicit && absl::IsUnavailable(server.status())) {
    spdlog::warn("no metrics and health pages: {}; set another address with --http-listen",
                 std::string(server.status().message()));
    return nullptr;
  }
  if (!server.ok()) return server.status();
  spdlog::info("metrics and health pages at http://{}/", (*server)->address());
  if (!(*server)->is_loopback()) {
    PrintAlways(
        format,
        fmt::format("http://{}/ has no authentication and no encryption: everyone who can reach it "
                    "can read the names, sizes and load of databases, but no motion, and cannot "
                    "change anything",
                    (*server)->address()));
  }
  return server;
}

namespace {

HttpAnswer Metrics(const Monitor& monitor) {
  return {.content_type = "text/plain; version=0.0.4; charset=utf-8", .body = monitor.Exposition()};
}

// With 503 a load balancer sends no calls here.
HttpAnswer Ready(const Monitor& monitor) {
  const Readiness readiness = monitor.CheckReadiness();
  return {.status = readiness.ready ? 200U : 503U, .body = readiness.reason + "\n"};
}

// If an exception occurs, such as out of memory, only this page fails.
HttpPage CatchExceptions(std::function<HttpAnswer()> make) {
  return {.make = [make = std::move(make)]() -> HttpAnswer {
    try {
      const AllocationsMayFail scope;
      return make();
    } catch (const std::exception& error) {
      return {.status = 500, .body = std::string(error.what()) + "\n"};
    }
  }};
}

}  // namespace

HttpPages HealthPages(const Monitor& monitor) {
  HttpPages pages;
  pages["/metrics"] = CatchExceptions([&monitor] { return Metrics(monitor); });
  pages["/readyz"] = CatchExceptions([&monitor] { return Ready(monitor); });
  // Does not check the store: a restart does not help if the disk hangs.
  pages["/livez"] = {.make = [] { return HttpAnswer{.body = "alive\n"}; }, .is_immediate = true};
  pages["/"] = {
      .make =
          [] {
            return HttpAnswer{
                .body =
                    "/metrics  metrics for Prometheus\n"
                    "/livez    200 while the process responds\n"
                    "/readyz   200 while queries are answered and clips are stored, else 503\n"};
          },
      .is_immediate = true};
  return pages;
}

}  // namespace motiondb::server
