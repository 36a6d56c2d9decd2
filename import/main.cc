// motiondb-import: reads motion files that may be malicious, each in a process of its own with
// limits on memory, time and system calls. `motiondb inspect` runs it.
#include <fmt/format.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <thread>

#include "import/inspector.h"

namespace motiondb::importer {
namespace {

struct Options {
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  int max_memory_mib = 2048;
  int max_cpu_seconds = 30;
  int max_file_mib = 64;  // as the server
  bool no_sandbox = false;
};

void Declare(CLI::App& inspect, Options& options) {
  inspect.add_option("--jobs", options.jobs, "Files at the same time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  inspect.add_option("--max-memory-mib", options.max_memory_mib, "Memory for one file")
      ->check(CLI::Range(16, 1 << 20))
      ->capture_default_str();
  inspect.add_option("--max-cpu-seconds", options.max_cpu_seconds, "Processor time for one file")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  inspect.add_option("--max-file-mib", options.max_file_mib, "Size of one file")
      ->check(CLI::Range(1, 1 << 16))
      ->capture_default_str();
  inspect.add_flag("--no-sandbox", options.no_sandbox, "Without limits, for debugging");
}

int Main(int argc, char** argv) {
  CLI::App app("motiondb-import: reads motion files in a sandbox, for motiondb", "motiondb-import");
  app.set_version_flag("--version", "motiondb-import " MOTIONDB_VERSION);
  app.require_subcommand(1);
  Options options;
  Declare(*app.add_subcommand("inspect",
                              "Answer requests on standard input, one JSON object per line, with "
                              "one line each"),
          options);
  CLI11_PARSE(app, argc, argv);
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // with `motiondb`, also if that is killed
  const InspectorOptions inspector{
      .jobs = options.jobs,
      .limits = {.memory_bytes = std::int64_t{options.max_memory_mib} << 20,
                 .cpu_seconds = options.max_cpu_seconds},
      .max_file_bytes = static_cast<std::size_t>(options.max_file_mib) << 20,
      .is_sandboxed = !options.no_sandbox};
  const absl::Status status = Inspector(inspector, stdout).Run(std::cin);
  if (status.ok()) return 0;
  fmt::print(stderr, "motiondb-import: {}\n", std::string(status.message()));
  return 1;
}

}  // namespace
}  // namespace motiondb::importer

int main(int argc, char** argv) {
  try {
    return motiondb::importer::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "motiondb-import: %s\n", error.what());
    return 1;
  }
}
