#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddEngineSettings(CLI::App& app, Settings& settings) {
  EngineOptions& engine = settings.server.engine;
  app.add_option("--threads", engine.query_threads, "Threads for requests; 0: one a core")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group("Engine");
  app.add_option("--heavy-threads", engine.heavy_threads,
                 "Of these, for long work such as plans and ingests; 0: all but one")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group("Engine");
  app.add_option("--build-threads", engine.build_threads,
                 "Threads for building models; 0: one for two cores")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group("Engine");
  AddSeconds(app, "--rebuild-delay", engine.rebuild_delay, 0, 3600,
             "Time without an ingest after which the model is rebuilt")
      ->group("Engine");
  AddSeconds(app, "--rebuild-delay-limit", engine.rebuild_delay_limit, 0, 86400,
             "Time after which it is rebuilt although ingests go on")
      ->group("Engine");
}

void CheckEngineSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const EngineOptions& engine = settings.server.engine;
  if (engine.rebuild_delay > engine.rebuild_delay_limit) {
    problems.push_back(absl::InvalidArgumentError(
        "rebuild-delay: is longer than rebuild-delay-limit, which would end every wait"));
  }
}

}  // namespace motiondb::server
