#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddEngineSettings(CLI::App& app, Settings& settings) {
  EngineOptions& engine = settings.server.engine;
  AddCount(app, "--threads", engine.query_threads, 0, 1024, "Threads for requests; 0: one a core")
      ->group("Engine");
  AddCount(app, "--heavy-threads", engine.heavy_threads, 0, 1024,
           "Of these, for long work such as plans and ingests; 0: all but one")
      ->group("Engine");
  AddCount(app, "--build-threads", engine.build_threads, 0, 1024,
           "Threads for building models; 0: one for two cores")
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
