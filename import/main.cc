// motiondb-import: reads motion files that may be malicious, each in a process of its own with
// limits on memory, time and system calls. `motiondb inspect` runs it.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <list>
#include <string>
#include <thread>
#include <vector>

#include "import/child.h"
#include "import/input_bytes.h"
#include "import/inspect_request.h"

namespace motiondb::importer {
namespace {

struct Options {
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  int max_memory_mib = 2048;
  int max_cpu_seconds = 30;
  int max_file_mib = 256;
  bool no_sandbox = false;
};

// A request in a child process.
struct Job {
  int index;
  std::string file;
  Child child;
};

class Inspector {
 public:
  explicit Inspector(const Options& options) : options_(options) {}

  // Answers one request per line of standard input on standard output, in any order.
  void Run() {
    std::string line;
    for (int index = 0; std::getline(std::cin, line); ++index) {
      while (static_cast<int>(jobs_.size()) >= options_.jobs) AwaitOne();
      Begin(index, line);
    }
    while (!jobs_.empty()) AwaitOne();
  }

 private:
  static void Answer(const std::string& line) {
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fflush(stdout);
  }

  void Begin(int index, const std::string& line) {
    const auto request = ParseInspectRequest(line);
    if (!request.ok()) return Answer(InspectionLine(index, "", request.status()));
    absl::Status status = Start(index, *request);
    if (!status.ok()) Answer(InspectionLine(index, request->file, status));
  }

  absl::Status Start(int index, const InspectRequest& request) {
    const auto format = core::FormatOfPath(request.file);
    if (!format.ok()) return format.status();
    const std::size_t max_bytes = static_cast<std::size_t>(options_.max_file_mib) << 20;
    const auto file = InputBytes::Open(request.file, max_bytes);
    if (!file.ok()) return file.status();
    InputBytes skeleton;
    if (!request.skeleton.empty()) {
      auto opened = InputBytes::Open(request.skeleton, max_bytes);
      if (!opened.ok()) {
        return absl::Status(
            opened.status().code(),
            fmt::format("{}: {}", request.skeleton, std::string(opened.status().message())));
      }
      skeleton = *std::move(opened);
    }
    const auto work = [&] {
      std::optional<core::SourceFile> of_skeleton;
      if (!request.skeleton.empty()) of_skeleton = {request.skeleton, skeleton.bytes()};
      return InspectionLine(index, request.file,
                            core::InspectMotion(*format, {request.file, file->bytes()}, of_skeleton,
                                                request.given, request.leg_length_m));
    };
    auto child = Child::Start(work,
                              {.memory_bytes = std::int64_t{options_.max_memory_mib} << 20,
                               .cpu_seconds = options_.max_cpu_seconds},
                              !options_.no_sandbox);
    if (!child.ok()) return child.status();
    jobs_.push_back({index, request.file, *std::move(child)});
    return absl::OkStatus();
  }

  // Reads from the children until one has ended, and answers its request.
  void AwaitOne() {
    while (true) {
      std::vector<pollfd> ready;
      ready.reserve(jobs_.size());
      for (const Job& job : jobs_) ready.push_back({job.child.descriptor(), POLLIN, 0});
      constexpr int kPollMilliseconds = 100;
      poll(ready.data(), ready.size(), kPollMilliseconds);
      auto state = ready.begin();
      for (auto job = jobs_.begin(); job != jobs_.end(); ++job, ++state) {
        const bool is_readable = (state->revents & (POLLIN | POLLHUP | POLLERR)) != 0;
        if (is_readable ? job->child.Read() : !job->child.IsOverdue()) continue;
        const auto output = job->child.Finish();
        Answer(output.ok() ? *output : InspectionLine(job->index, job->file, output.status()));
        jobs_.erase(job);
        return;
      }
    }
  }

  const Options options_;
  std::list<Job> jobs_;
};

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
  CLI11_PARSE(app, argc, argv);
  Inspector(options).Run();
  return 0;
}

}  // namespace
}  // namespace motiondb::importer

int main(int argc, char** argv) { return motiondb::importer::Main(argc, argv); }
