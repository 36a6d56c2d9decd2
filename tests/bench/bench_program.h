// The frame of every benchmark program with a table: options, the check for recorded motion, and
// the table on standard output and in a file.
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
  // Adds --clips and --frames.
  void AddSize(VariedSize& size);
  // Adds --jobs, by default the number of processors.
  void AddJobs(int& jobs, const std::string& what);

  // Parses the command line, measures and reports. Returns the exit code. `instead` runs after
  // parsing; if it returns an exit code, nothing is measured.
  int Run(int argc, char** argv, const std::function<absl::StatusOr<BenchTable>()>& measure,
          const std::function<std::optional<int>()>& instead = {});

  // Prints an error, if any, to standard error. Returns the exit code.
  int Report(const absl::Status& status) const;

 private:
  CLI::App app_;
  std::string json_;
};

}  // namespace motiondb::tests
