#include "server/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

namespace motiondb::server {
namespace {

std::chrono::milliseconds FromSeconds(double seconds) {
  return std::chrono::milliseconds(std::llround(seconds * 1000));
}

}  // namespace

bool ParseCommandLine(int argc, const char* const* argv, CommandLine& line, int& exit_code) {
  EngineOptions& engine = line.server.engine;
  const auto seconds = [](std::chrono::milliseconds time) {
    return static_cast<double>(time.count()) / 1000;
  };
  double grace_seconds = seconds(line.grace);
  double rebuild_delay = seconds(engine.rebuild_delay);
  double rebuild_delay_limit = seconds(engine.rebuild_delay_limit);
  int max_message_mib = line.server.max_message_bytes >> 20;
  int max_file_mib = static_cast<int>(engine.max_file_bytes >> 20);

  CLI::App app("motiondbd: a database server for human motion", "motiondbd");
  app.set_version_flag("--version", "motiondbd " MOTIONDB_VERSION);
  app.add_option("--store", line.store_path, "The file that holds the databases; made if absent")
      ->required();
  app.add_option("--listen", line.server.listen, "HOST:PORT to answer at; port 0 takes a free one")
      ->capture_default_str();
  app.add_option("--threads", engine.query_threads, "Threads for requests; 0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--build-threads", engine.build_threads,
                 "Threads for building models; 0: one for two cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--rebuild-delay", rebuild_delay,
                 "Seconds without an ingest after which the model is rebuilt")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option("--rebuild-delay-limit", rebuild_delay_limit,
                 "Seconds after which it is rebuilt although ingests go on")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--max-file-mib", max_file_mib, "Largest motion file taken, with its skeleton")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--max-message-mib", max_message_mib, "Largest request taken")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--max-frames", engine.max_frames,
                 "Longest clip or observation, in frames at the database's frame rate")
      ->check(CLI::Range(2, 100'000'000))
      ->capture_default_str();
  app.add_option("--grace-seconds", grace_seconds,
                 "Seconds that running calls may take after SIGTERM")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option("--log-level", line.log_level, "What to log on standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // help or version
    exit_code = app.exit(asked);
    return false;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "motiondbd: {}\nTry `motiondbd --help`.\n", error.what());
    exit_code = 2;
    return false;
  }
  line.grace = FromSeconds(grace_seconds);
  engine.rebuild_delay = FromSeconds(rebuild_delay);
  engine.rebuild_delay_limit = FromSeconds(rebuild_delay_limit);
  engine.max_file_bytes = static_cast<std::size_t>(max_file_mib) << 20;
  line.server.max_message_bytes = max_message_mib << 20;
  return true;
}

}  // namespace motiondb::server
