#include "server/settings/groups.h"

namespace motiondb::server {

void AddLogSettings(CLI::App& app, Settings& settings) {
  app.add_option("--log-level", settings.log.level, "What to log on standard error")
      ->type_name("LEVEL")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str()
      ->group("Log");
}

}  // namespace motiondb::server
