#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddLogSettings(CLI::App& app, Settings& settings) {
  app.add_option("--log-level", settings.log.level, "What to log on standard error")
      ->type_name("LEVEL")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str()
      ->group("Log");
  app.add_option_function<std::string>(
         "--log-format",
         [&settings](const std::string& format) {
           settings.log.format = format == "json" ? LogFormat::kJson : LogFormat::kText;
         },
         "Lines of text for a person, or one JSON object a line")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text")
      ->group("Log");
  AddSeconds(app, "--slow-call-seconds", settings.log.slow_call, 0, 3600,
             "From how long on a call is logged as slow, with a warning; 0: never")
      ->group("Log");
}

}  // namespace motiondb::server
