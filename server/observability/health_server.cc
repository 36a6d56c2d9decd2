#include "server/observability/health_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

#include "server/engine/memory_reserve.h"
#include "server/observability/log.h"

namespace motiondb::server {

absl::StatusOr<std::unique_ptr<HttpServer>> StartHealthServer(const std::string& listen,
                                                              const Monitor& monitor,
                                                              LogFormat format) {
  if (listen == "none") return nullptr;
  const bool asked_for = !listen.empty();
  auto server = HttpServer::Start(asked_for ? listen : kDefaultHttpListen, HealthPages(monitor));
  if (!asked_for && absl::IsUnavailable(server.status())) {
    spdlog::warn("no metrics and health pages: {}; choose another address with --http-listen",
                 std::string(server.status().message()));
    return nullptr;
  }
  if (!server.ok()) return server.status();
  spdlog::info("metrics and health pages at http://{}/", (*server)->address());
  if (!(*server)->is_loopback()) {
    Tell(format,
         fmt::format("whoever reaches http://{}/ reads, unencrypted and without authentication, "
                     "the names of databases and how much they hold and are used; it shows no "
                     "motion and changes nothing",
                     (*server)->address()));
  }
  return server;
}

namespace {

HttpAnswer Metrics(const Monitor& monitor) {
  return {.content_type = "text/plain; version=0.0.4; charset=utf-8", .body = monitor.Exposition()};
}

// 503: whoever spreads calls sends none here.
HttpAnswer Ready(const Monitor& monitor) {
  const Readiness readiness = monitor.CheckReadiness();
  return {.status = readiness.ready ? 200U : 503U, .body = readiness.reason + "\n"};
}

// As where no memory is left: one page fails, the server goes on.
HttpPage Guarded(std::function<HttpAnswer()> make) {
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
  pages["/metrics"] = Guarded([&monitor] { return Metrics(monitor); });
  pages["/readyz"] = Guarded([&monitor] { return Ready(monitor); });
  // Alive while it answers at all: a disk that hangs is no reason to be started anew.
  pages["/livez"] = {.make = [] { return HttpAnswer{.body = "alive\n"}; }, .at_once = true};
  pages["/"] = {
      .make =
          [] {
            return HttpAnswer{
                .body =
                    "/metrics  figures for Prometheus\n"
                    "/livez    200 while the process answers\n"
                    "/readyz   200 while queries are answered and clips stored, else 503\n"};
          },
      .at_once = true};
  return pages;
}

}  // namespace motiondb::server
