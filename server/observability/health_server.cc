#include "server/observability/health_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/observability/health_pages.h"
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

}  // namespace motiondb::server
