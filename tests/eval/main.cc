// motiondb_eval: recognition and prediction on recorded motion, compared with peers.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/eval/protocols/protocol.h"
#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

struct Options {
  std::string data = DataDir().string();
  std::vector<std::string> protocols;
  int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  double frame_rate_hz = 60;
  int window_step = 1;
  std::string json;
};

void AddOptions(CLI::App& app, Options& options) {
  std::vector<std::string> names;
  for (const Protocol& protocol : Protocols()) names.push_back(protocol.name);
  options.protocols = names;
  app.add_option("--data", options.data, "Folder of recorded motion with index.tsv and sets/")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--protocol", options.protocols, "Protocols to run, separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("NAME,...");
  app.add_option("--jobs", options.jobs, "Threads; they affect only the times")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--rate", options.frame_rate_hz, "Frame rate of recognition, Hz")
      ->check(CLI::Range(5.0, 1000.0))
      ->capture_default_str();
  app.add_option("--window-step", options.window_step,
                 "Frames from one window of the prediction protocol to the next")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--json", options.json, "Also write the tables to this file")->type_name("FILE");
}

// Runs the selected protocols in order; prints each when it is done.
absl::StatusOr<nlohmann::json> Run(const Options& options) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  Progress progress;
  const std::filesystem::path data(options.data);
  const core::ParallelFor parallel = RunOnThreads(options.jobs);
  Studies studies{{data, options.frame_rate_hz, parallel, progress},
                  {data, options.window_step, parallel, progress}};
  nlohmann::json all = {{"frame_rate_hz", options.frame_rate_hz},
                        {"window_step", options.window_step},
                        {"protocols", nlohmann::json::array()}};
  const Clock::time_point begin = Clock::now();
  for (const Protocol& protocol : Protocols()) {
    const auto asked = std::find(options.protocols.begin(), options.protocols.end(), protocol.name);
    if (asked == options.protocols.end()) continue;
    const Clock::time_point protocol_begin = Clock::now();
    absl::StatusOr<Tables> tables = protocol.run(studies);
    if (!tables.ok()) return tables.status();
    progress.Clear();
    fmt::print("### {}\n\n", protocol.title);
    nlohmann::json in_json = nlohmann::json::array();
    for (const Table& table : *tables) {
      fmt::print("{}\n", ToMarkdown(table));
      in_json.push_back(ToJson(table));
    }
    std::fflush(stdout);
    all["protocols"].push_back({{"name", protocol.name},
                                {"title", protocol.title},
                                {"seconds", seconds_since(protocol_begin)},
                                {"tables", in_json}});
  }
  fmt::print("{:.0f} s on {} threads; recognition at {} Hz.\n", seconds_since(begin), options.jobs,
             options.frame_rate_hz);
  return all;
}

int Main(int argc, char** argv) {
  CLI::App app("Measures recognition and prediction on recorded motion, compared with peers.",
               "motiondb_eval");
  Options options;
  AddOptions(app, options);
  CLI11_PARSE(app, argc, argv);
  const auto fail = [](const std::string& why) {
    fmt::print(stderr, "motiondb_eval: {}\n", why);
    return 1;
  };
  if (!std::filesystem::exists(std::filesystem::path(options.data) / "index.tsv")) {
    return fail(fmt::format("no recorded motion at {}: expected an index.tsv there (see --data)",
                            options.data));
  }
  const absl::StatusOr<nlohmann::json> results = Run(options);
  if (!results.ok()) return fail(std::string(results.status().message()));
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    file << results->dump(2) << '\n';
    if (!file.flush()) return fail(fmt::format("{}: cannot write the file", options.json));
  }
  return 0;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
