#include "tests/bench/bench_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "tests/support/real_data.h"

namespace motiondb::tests {

BenchProgram::BenchProgram(const std::string& description, const std::string& name)
    : app_(description, name) {
  app_.add_option("--json", json_, "Also write the table to this file")->type_name("FILE");
}

void BenchProgram::AddSize(VariedSize& size) {
  app_.add_option("--clips", size.clips, "Stored clips")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app_.add_option("--frames", size.frames, "Stored frames")
      ->check(CLI::Range(1000, 100'000'000))
      ->capture_default_str();
}

void BenchProgram::AddJobs(int& jobs, const std::string& what) {
  jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  app_.add_option("--jobs", jobs, what)->check(CLI::Range(1, 1024))->capture_default_str();
}

int BenchProgram::Run(int argc, char** argv,
                      const std::function<absl::StatusOr<BenchTable>()>& measure,
                      const std::function<std::optional<int>()>& instead) {
  CLI11_PARSE(app_, argc, argv);
  if (instead) {
    if (const auto code = instead()) return *code;
  }
  if (!std::filesystem::exists(DataDir() / "index.tsv")) {
    fmt::print("skipped: no recorded motion in {}\n", DataDir().string());
    return 0;
  }
  const absl::StatusOr<BenchTable> table = measure();
  return table.ok() ? Finish(*table, json_) : Report(table.status());
}

int BenchProgram::Report(const absl::Status& status) const {
  if (status.ok()) return 0;
  fmt::print(stderr, "{}: {}\n", app_.get_name(), std::string(status.message()));
  return 1;
}

}  // namespace motiondb::tests
