#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddNetworkSettings(CLI::App& app, Settings& settings) {
  app.add_option("--listen", settings.server.listen,
                 "Where to answer gRPC; port 0 takes a free one")
      ->type_name("HOST:PORT")
      ->check(ListenAddress())
      ->capture_default_str()
      ->group("Network");
  AddSeconds(app, "--grace-seconds", settings.grace, 0, 3600,
             "How long running calls may take after SIGTERM")
      ->group("Network");
}

}  // namespace motiondb::server
