// Measures time and memory of a rebuild, from stored clips to the calibrated and stored model: of
// all recorded clips, and of many varied ones. Each build runs alone in a new process. Stage times
// are wall time, with processor time in brackets.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/large_store.h"
#include "tests/support/child_process.h"
#include "tests/support/corpus.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kRecordedSeconds = 3;
constexpr double kVariedSeconds = 15;
constexpr double kMaxMegabytes = 1600;

struct Options {
  VariedSize size;
  double recorded_rate_hz = 120;
  std::string stores;  // folder
  std::string build;   // set in the child that builds the model of this store
  int jobs = 1;
};

// Runs in the child. Prints a line for each stage, then one for the whole build.
absl::Status Build(const std::string& path, int jobs) {
  spdlog::set_level(spdlog::level::off);  // the parent reads standard output
  const auto began = std::chrono::steady_clock::now();
  MOTIONDB_ASSIGN_OR_RETURN(const auto stages, RebuildStore(path, RunOnThreads(jobs)));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  double processors = 0;
  for (const BuildStage& stage : stages) {
    fmt::print("stage {} {} {} {}\n", stage.seconds, stage.processor_seconds, stage.peak_mb,
               stage.name);
    processors += stage.processor_seconds;
  }
  fmt::print("whole {} {} {} -\n", took.count(), processors, stages.back().peak_mb);
  return absl::OkStatus();
}

struct Built {
  BuildStage whole;
  std::string stages;  // readable summary
};

absl::StatusOr<Built> BuildInChild(const std::string& store, const Options& options) {
  // Copies the store, so that the next child does not find this child's model.
  const std::string copy = store + ".built";
  std::filesystem::copy_file(store, copy, std::filesystem::copy_options::overwrite_existing);
  ChildProcess child({std::filesystem::read_symlink("/proc/self/exe").string(), "--build", copy,
                      "--jobs", std::to_string(options.jobs)});
  Built built;
  while (built.whole.name.empty()) {
    std::istringstream line(child.ReadLine());
    std::string kind;
    BuildStage stage;
    line >> kind >> stage.seconds >> stage.processor_seconds >> stage.peak_mb >> std::ws;
    std::getline(line, stage.name);
    if (stage.name.empty()) return absl::InternalError("the measured build failed");
    if (kind == "whole") {
      built.whole = stage;
    } else {
      built.stages +=
          fmt::format("{}{} {:.2f} s [{:.2f}], {:.0f} MB", built.stages.empty() ? "" : "; ",
                      stage.name, stage.seconds, stage.processor_seconds, stage.peak_mb);
    }
  }
  if (child.Wait() != 0) return absl::InternalError("the measured build failed");
  std::filesystem::remove(copy);
  return built;
}

absl::StatusOr<std::vector<core::BuildInput>> RecordedClips(double rate_hz,
                                                            const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(Corpus corpus, LoadIndexedCorpus(DataDir(), rate_hz, parallel));
  std::vector<core::BuildInput> inputs;
  for (auto& clip : corpus.clips) {
    inputs.push_back({clip->name, clip->label, std::move(clip->states), clip->source});
  }
  return inputs;
}

// Creates a store only if it does not exist yet.
absl::Status Measure(const std::string& store, const std::string& what, double rate_hz,
                     double bar_seconds, const Options& options,
                     const std::function<absl::StatusOr<std::vector<core::BuildInput>>()>& clips,
                     BenchTable& table) {
  if (!std::filesystem::exists(store)) {
    MOTIONDB_ASSIGN_OR_RETURN(auto inputs, clips());
    MOTIONDB_RETURN_IF_ERROR(MakeClipStore(store, rate_hz, std::move(inputs)));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const Built built, BuildInChild(store, options));
  const BuildStage& whole = built.whole;
  table.rows.push_back(RatioRow(fmt::format("rebuild of {}", what), whole.seconds, "the bar",
                                bar_seconds, "s", AtMost(1)));
  table.rows.push_back(RatioRow(fmt::format("its processor time, {}", what),
                                whole.processor_seconds, "two processors for the bar's time",
                                2 * bar_seconds, "s", AtMost(1)));
  table.rows.push_back(RatioRow(fmt::format("its peak of memory, {}", what), whole.peak_mb,
                                "the bar", kMaxMegabytes, "MB", AtMost(1)));
  table.notes.push_back(
      fmt::format("rebuild: {}, {} threads: {}", what, options.jobs, built.stages));
  return absl::OkStatus();
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  const TemporaryDirectory directory;
  const std::filesystem::path stores = options.stores.empty()
                                           ? std::filesystem::path(directory / "")
                                           : std::filesystem::path(options.stores);
  const core::ParallelFor parallel = RunOnThreads(options.jobs);
  BenchTable table{"rebuild", {}, {}};
  MOTIONDB_RETURN_IF_ERROR(Measure(
      stores / fmt::format("recorded-{:g}.db", options.recorded_rate_hz),
      fmt::format("all recorded clips at {:g} Hz", options.recorded_rate_hz),
      options.recorded_rate_hz, kRecordedSeconds, options,
      [&] { return RecordedClips(options.recorded_rate_hz, parallel); }, table));
  const VariedSize& size = options.size;
  MOTIONDB_RETURN_IF_ERROR(Measure(
      stores / fmt::format("varied-{}-{}.db", size.clips, size.frames),
      fmt::format("{} frames in {} clips at {:g} Hz", size.frames, size.clips, size.frame_rate_hz),
      size.frame_rate_hz, kVariedSeconds, options,
      [&] { return VariedClips(DataDir(), size, kSeed, parallel); }, table));
  table.notes.push_back(fmt::format("rebuild: {}", kVariedMotion));
  return table;
}

int Main(int argc, char** argv) {
  BenchProgram program("Measures rebuilds.", "motiondb_bench_rebuild");
  Options options;
  program.AddSize(options.size);
  program.AddJobs(options.jobs, "Threads of the build");
  program.app()
      .add_option("--recorded-rate", options.recorded_rate_hz, "Frame rate of recorded clips, Hz")
      ->check(CLI::Range(5.0, 1000.0))
      ->capture_default_str();
  program.app()
      .add_option("--stores", options.stores, "Keep the stores in this folder for later runs")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  program.app().add_option("--build", options.build)->group("");
  const auto child = [&]() -> std::optional<int> {
    if (options.build.empty()) return std::nullopt;
    return program.Report(Build(options.build, options.jobs));
  };
  return program.Run(
      argc, argv, [&] { return Run(options); }, child);
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
