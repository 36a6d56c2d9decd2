// Measures the cost of a large database for a server: time from start to first answer, compared
// with reading the file; and memory while serving, compared with the matrix of its states. Each is
// measured in a new process, with the file in the page cache; the readers are processes too, in
// turn.
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <future>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/motion/error.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/large_store.h"
#include "tests/support/child_process.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kWindowSeconds = 0.4;

struct Options {
  VariedSize size;
  std::string store;
  int rounds = 5;
  int queries = 400;  // before memory is measured; half recognize, half predict
  int jobs = 1;
  std::string read;   // set in the child that reads this file without keeping it
  std::string load;   // set in the child that reads this file into memory
  std::string serve;  // set in the child that serves this store
};

// ---- The children. Each prints a line when its timed work is done.

// Reads into memory of the file's size (`keep`), or repeatedly into one megabyte that stays in the
// CPU caches.
absl::Status ReadOnce(const std::string& path, bool keep) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return core::NotFound("{}: cannot read the file", path);
  constexpr std::size_t kGrpcThread = std::size_t{1} << 20;
  const std::size_t room = keep ? std::filesystem::file_size(path) + kGrpcThread : kGrpcThread;
  const auto buffer = std::make_unique_for_overwrite<char[]>(room);
  ssize_t count = 0;
  for (std::size_t at = 0; (count = read(file, buffer.get() + at, kGrpcThread)) > 0;) {
    if (keep) at += static_cast<std::size_t>(count);
  }
  close(file);
  if (count < 0) return core::DataLoss("{}: cannot read the file", path);
  fmt::print("read\n");
  return absl::OkStatus();
}

// Returns a stored moment as an observation.
core::StateSequence StoredWindow(const core::Model& model, int i) {
  core::StateSequence motion =
      core::StoredMotion(model, static_cast<int>(i * 37 % model.clips().size()));
  const auto wanted = static_cast<int>(kWindowSeconds * motion.frame_rate_hz + 0.5);
  const int frames = std::min(motion.frame_count(), wanted);
  motion.states = core::FrameMatrix(motion.states.topRows(frames));
  motion.root_path = core::RootPath(motion.root_path.topRows(frames));
  return motion;
}

absl::Status Ask(const core::Model& model, int i) {
  const core::StateSequence window = StoredWindow(model, i);
  if (i % 2 == 1) return core::Predict(model, window, {}).status();
  core::RecognizeOptions options;
  options.window_seconds = kWindowSeconds;
  return core::Recognize(model, window, options).status();
}

// Runs all queries on the server's own threads, which have their own heaps.
absl::Status AskMany(server::Workers& workers, const core::Model& model, int queries) {
  std::vector<std::promise<absl::Status>> answers(queries);
  for (int i = 0; i < queries; ++i) {
    workers.Post(server::Pool::kRequests, [&, i] { answers[i].set_value(Ask(model, i)); });
  }
  absl::Status status;
  for (auto& answer : answers) status.Update(answer.get_future().get());
  return status;
}

absl::Status Serve(const std::string& path, int queries) {
  spdlog::set_level(spdlog::level::off);  // the parent reads standard output
  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_ASSIGN_OR_RETURN(const auto engine, server::Engine::Open(std::move(store), {}));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine->FindDatabase(kLargeDatabase));
  MOTIONDB_ASSIGN_OR_RETURN(const auto snapshot, engine->CurrentModel(*live));
  const core::Model& model = snapshot->model;
  MOTIONDB_RETURN_IF_ERROR(Ask(model, 0));
  fmt::print("answered\n");
  std::fflush(stdout);
  const double started_mb = ProcessMegabytes("VmHWM");
  MOTIONDB_RETURN_IF_ERROR(AskMany(engine->workers(), model, queries));
  fmt::print("{} {} {} {} {}\n", started_mb, ProcessMegabytes("VmRSS"), model.frame_count(),
             model.clips().size(), model.states().cols());
  return absl::OkStatus();
}

// ---- The parent.

struct Served {
  std::vector<double> load_ms;
  std::vector<double> read_ms;
  std::vector<double> start_ms;
  double start_peak_mb = 0;  // maximum over the rounds
  double serving_mb = 0;
  double frames = 0;
  int clips = 0;
  int dimensions = 0;
};

// Returns the time until the child prints the expected line.
absl::StatusOr<double> Milliseconds(ChildProcess& child, const std::string& expected,
                                    std::chrono::steady_clock::time_point began) {
  const std::string line = child.ReadLine();
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  if (line != expected) return absl::InternalError("the measured process failed");
  return took.count();
}

absl::StatusOr<double> ReadIn(const std::string& program, const std::string& how,
                              const std::string& store) {
  const auto began = std::chrono::steady_clock::now();
  ChildProcess reader({program, how, store});
  MOTIONDB_ASSIGN_OR_RETURN(const double ms, Milliseconds(reader, "read", began));
  reader.Wait();
  return ms;
}

absl::StatusOr<Served> Measure(const std::string& program, const std::string& store,
                               const Options& options) {
  Served served;
  for (int r = 0; r < options.rounds; ++r) {
    MOTIONDB_ASSIGN_OR_RETURN(served.read_ms.emplace_back(), ReadIn(program, "--read", store));
    MOTIONDB_ASSIGN_OR_RETURN(served.load_ms.emplace_back(), ReadIn(program, "--load", store));
    const auto starting = std::chrono::steady_clock::now();
    ChildProcess server({program, "--serve", store, "--queries", std::to_string(options.queries)});
    MOTIONDB_ASSIGN_OR_RETURN(served.start_ms.emplace_back(),
                              Milliseconds(server, "answered", starting));
    std::istringstream figures(server.ReadLine());
    double peak_mb = 0, serving_mb = 0;
    figures >> peak_mb >> serving_mb >> served.frames >> served.clips >> served.dimensions;
    if (!figures || server.Wait() != 0) return absl::InternalError("the measured server failed");
    served.start_peak_mb = std::max(served.start_peak_mb, peak_mb);
    served.serving_mb = std::max(served.serving_mb, serving_mb);
    fmt::print(
        stderr,
        "read {:.0f} ms, loaded {:.0f}, first answer after {:.0f}; {:.0f} MB, serving {:.0f}\n",
        served.read_ms.back(), served.load_ms.back(), served.start_ms.back(), peak_mb, serving_mb);
  }
  return served;
}

std::string Describe(const std::vector<BuildStage>& stages) {
  std::string text;
  for (const BuildStage& stage : stages) {
    text += fmt::format("{}{} {:.1f} s", text.empty() ? "" : ", ", stage.name, stage.seconds);
  }
  return fmt::format("{}; peak {:.0f} MB", text, stages.back().peak_mb);
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

BenchTable Tabulate(const Served& served, std::uintmax_t file_bytes, const Options& options) {
  BenchTable table{"scale", {}, {}};
  const std::string size = served.frames >= 1e6 ? fmt::format("{:g}M frames", served.frames / 1e6)
                                                : fmt::format("{:g}k frames", served.frames / 1e3);
  const double start_ms = Median(served.start_ms);
  table.rows.push_back(RatioRow("start-up to first answer, " + size, start_ms,
                                "reading the file into memory", Median(served.load_ms), "ms",
                                AtMost(2)));
  table.rows.push_back(RatioRow("start-up to first answer, " + size, start_ms,
                                "reading the file, keeping nothing", Median(served.read_ms), "ms",
                                AtMost(2)));
  table.rows.back().note =
      "the reader reuses one megabyte and never writes to memory; a server keeps the data";
  table.rows.push_back(RatioRow("memory while serving, " + size, served.serving_mb,
                                "the float32 matrix", 4 * served.frames * served.dimensions / 1e6,
                                "MB", AtMost(1.5)));
  table.notes.push_back(fmt::format(
      "scale: {}, {} clips, a file of {:.0f} MB; medians of {} process starts, the file in the "
      "page cache; a query has 0.4 s of motion; read(2) reads one megabyte at a time",
      kVariedMotion, served.clips, static_cast<double>(file_bytes) / 1e6, options.rounds));
  table.notes.push_back(fmt::format(
      "scale: memory is resident memory after {} queries on the server's threads (maximum of {} "
      "starts), without the transport; peak {:.0f} MB during the start",
      options.queries, options.rounds, served.start_peak_mb));
  return table;
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  const TemporaryDirectory directory;
  const std::string store = options.store.empty() ? directory / "large.db" : options.store;
  std::vector<BuildStage> stages;
  if (!std::filesystem::exists(store)) {
    // Renamed to its final path only when complete.
    const std::string making = store + ".making";
    MOTIONDB_ASSIGN_OR_RETURN(
        stages, MakeLargeStore(making, options.size, kSeed, RunOnThreads(options.jobs)));
    std::filesystem::rename(making, store);
    std::filesystem::remove(making + "-lock");  // left by the store
    fmt::print(stderr, "{}\n", Describe(stages));
  }
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  MOTIONDB_ASSIGN_OR_RETURN(const Served served, Measure(program, store, options));
  BenchTable table = Tabulate(served, std::filesystem::file_size(store), options);
  if (!stages.empty()) {
    table.notes.push_back(fmt::format("scale: the store was created with {} threads: {}",
                                      options.jobs, Describe(stages)));
  }
  return table;
}

int Main(int argc, char** argv) {
  BenchProgram program("Measures the cost of a large database for a server.",
                       "motiondb_bench_scale");
  Options options;
  program.AddSize(options.size);
  CLI::App& app = program.app();
  app.add_option("--store", options.store, "Use this store; create it if it does not exist")
      ->type_name("FILE");
  app.add_option("--rounds", options.rounds, "Number of starts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--queries", options.queries, "Queries before memory is measured")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads that create the store");
  app.add_option("--read", options.read)->group("");
  app.add_option("--load", options.load)->group("");
  app.add_option("--serve", options.serve)->group("");
  const auto child = [&]() -> std::optional<int> {
    if (!options.read.empty()) return program.Report(ReadOnce(options.read, /*keep=*/false));
    if (!options.load.empty()) return program.Report(ReadOnce(options.load, /*keep=*/true));
    if (!options.serve.empty()) return program.Report(Serve(options.serve, options.queries));
    return std::nullopt;
  };
  return program.Run(
      argc, argv, [&] { return Run(options); }, child);
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
