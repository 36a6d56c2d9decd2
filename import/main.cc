// motiondb-import: reads motion files that may be malicious, each in a process of its own with
// limits on memory, time and system calls. motiondbd and `motiondb inspect` and `convert` run it.
#include <fmt/format.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <thread>

#include "core/format/text_scanner.h"
#include "import/inspector.h"
#include "import/single_file.h"

namespace motiondb::importer {
namespace {

struct Options {
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  int max_memory_mib = 2048;
  int max_cpu_seconds = 30;
  int max_file_mib = 64;  // as the server
  int max_plain_mib = 256;
  bool no_sandbox = false;
};

void DeclareLimits(CLI::App& command, Options& options) {
  command.add_option("--max-memory-mib", options.max_memory_mib, "Memory for one file")
      ->check(CLI::Range(16, 1 << 20))
      ->capture_default_str();
  command.add_option("--max-cpu-seconds", options.max_cpu_seconds, "Processor time for one file")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  command.add_option("--max-file-mib", options.max_file_mib, "Size of one file")
      ->check(CLI::Range(1, 1 << 16))
      ->capture_default_str();
  command
      .add_option("--max-plain-mib", options.max_plain_mib, "Size of one file after decompression")
      ->check(CLI::Range(1, 1 << 16))
      ->capture_default_str();
  command.add_flag("--no-sandbox", options.no_sandbox, "Without limits, for debugging");
}

FileLimits LimitsOf(const Options& options) {
  return {.process = {.memory_bytes = std::int64_t{options.max_memory_mib} << 20,
                      .cpu_seconds = options.max_cpu_seconds},
          .max_file_bytes = static_cast<std::size_t>(options.max_file_mib) << 20,
          .max_plain_bytes = static_cast<std::size_t>(options.max_plain_mib) << 20,
          .is_sandboxed = !options.no_sandbox};
}

absl::Status Inspect(const Options& options) {
  return Inspector({.jobs = options.jobs, .limits = LimitsOf(options)}, stdout).Run(std::cin);
}

absl::Status AnswerOne(SingleFileTask task, const Options& options) {
  FileLimits limits = LimitsOf(options);
  limits.process.result_bytes = limits.process.memory_bytes;
  std::string line;
  std::getline(std::cin, line);
  return AnswerSingleFile(task, line, limits, stdout);
}

int Main(int argc, char** argv) {
  CLI::App app("motiondb-import: reads motion files in a sandbox, for motiondb", "motiondb-import");
  app.set_version_flag("--version", "motiondb-import " MOTIONDB_VERSION);
  app.require_subcommand(1);
  Options options;
  CLI::App& inspect = *app.add_subcommand(
      "inspect", "Answer requests on standard input, one JSON object per line, with one line each");
  inspect.add_option("--jobs", options.jobs, "Files at the same time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  DeclareLimits(inspect, options);
  const CLI::App& formats =
      *app.add_subcommand("formats", "Print what formats are read and written");
  const CLI::App& read = *app.add_subcommand(
      "read", "Answer one request with a line of JSON and the motion in binary form");
  app.add_subcommand("convert",
                     "Answer one request with a line of JSON and a file in another format");
  for (CLI::App* const command :
       app.get_subcommands([&](CLI::App* one) { return one != &inspect && one != &formats; })) {
    DeclareLimits(*command, options);
  }
  CLI11_PARSE(app, argc, argv);
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // with the program that runs it, also if that is killed
  if (formats.parsed()) {
    fmt::print("{}\n", FormatsJson());
    return 0;
  }
  const absl::Status status =
      inspect.parsed()
          ? Inspect(options)
          : AnswerOne(read.parsed() ? SingleFileTask::kRead : SingleFileTask::kConvert, options);
  if (status.ok()) return 0;
  constexpr std::size_t kShownBytes = 200;
  fmt::print(stderr, "motiondb-import: {}\n",
             core::Shown(std::string(status.message()).substr(0, kShownBytes)));
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
