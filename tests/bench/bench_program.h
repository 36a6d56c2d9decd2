// What every benchmark program that writes a table does around its work: options, a look whether
// the recorded motion is there, the table on standard output and in a file.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "tests/bench/bench_table.h"
#include "tests/bench/varied_motion.h"

namespace motiondb::tests {

class BenchProgram {
 public:
  BenchProgram(const std::string& description, const std::string& name);

  CLI::App& app() { return app_; }
  // --clips and --frames.
  void AddSize(VariedSize& size);
  // --jobs: as many as the machine has processors, if nothing is said.
  void AddJobs(int& jobs, const std::string& what);

  // Reads the command line, measures and reports; returns the exit code. `instead`, asked once the
  // options are known, may return an exit code for something else that was to be done.
  int Run(int argc, char** argv, const std::function<absl::StatusOr<BenchTable>()>& measure,
          const std::function<std::optional<int>()>& instead = {});

  // Says on standard error what went wrong, if something did; returns the exit code.
  int Report(const absl::Status& status) const;

 private:
  CLI::App app_;
  std::string json_;
};

}  // namespace motiondb::tests
