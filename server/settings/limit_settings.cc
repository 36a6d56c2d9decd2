#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddLimitSettings(CLI::App& app, Settings& settings) {
  AddMebibytes(app, "--max-file-mib", settings.server.engine.max_file_bytes,
               "Largest motion file taken, with its skeleton")
      ->group("Limits");
  AddMebibytes(app, "--max-message-mib", settings.server.max_message_bytes, "Largest request taken")
      ->group("Limits");
  app.add_option("--max-frames", settings.server.engine.max_frames,
                 "Longest clip or observation, in frames at the database's frame rate")
      ->type_name("N")
      ->check(CLI::Range(2, 100'000'000))
      ->capture_default_str()
      ->group("Limits");
}

}  // namespace motiondb::server
