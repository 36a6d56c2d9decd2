// Measures write rates of a store: clips from one and from several clients, compared with writing
// and syncing as many bytes; and a small change, alone and while a large model is stored.
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/large_store.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kSeed = 1;

struct Options {
  VariedSize size{300, 150'000};
  int jobs = 1;
  int models = 10;  // number of times that the model is stored
};

double Seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

// Returns the clips per second that the clients add concurrently to a new store.
absl::StatusOr<double> AddedPerSecond(const std::string& path,
                                      const std::vector<core::BuildInput>& clips, int clients) {
  MOTIONDB_RETURN_IF_ERROR(MakeClipStore(path, clips.front().states.frame_rate_hz, {}));
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  std::vector<std::vector<core::BuildInput>> shares(static_cast<std::size_t>(clients));
  for (std::size_t i = 0; i < clips.size(); ++i) shares[i % shares.size()].push_back(clips[i]);
  std::vector<absl::Status> added(shares.size());
  const auto began = Clock::now();
  {
    std::vector<std::jthread> threads;
    for (std::size_t c = 0; c < shares.size(); ++c) {
      threads.emplace_back([&, c] { added[c] = AddClips(*store, std::move(shares[c])); });
    }
  }
  const double seconds = Seconds(Clock::now() - began);
  for (const absl::Status& status : added) MOTIONDB_RETURN_IF_ERROR(status);
  return static_cast<double>(clips.size()) / seconds;
}

// Returns the rate of appending as many bytes to a file, synced after each clip.
absl::StatusOr<double> SyncedPerSecond(const std::string& path,
                                       const std::vector<core::BuildInput>& clips) {
  const int file = open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) return absl::UnavailableError("cannot write " + path);
  const auto began = Clock::now();
  bool written = true;
  for (const core::BuildInput& clip : clips) {
    const std::size_t bytes = sizeof(float) * clip.states.states.size();
    written &= write(file, clip.states.states.data(), bytes) == static_cast<ssize_t>(bytes) &&
               fdatasync(file) == 0;
  }
  const double seconds = Seconds(Clock::now() - began);
  close(file);
  if (!written) return absl::UnavailableError("cannot write " + path);
  return static_cast<double>(clips.size()) / seconds;
}

struct Times {
  double median = 0;  // milliseconds
  double p99 = 0;     // 99th percentile
};

// Measures small changes, one by one, until `enough`.
absl::StatusOr<Times> TimeChanges(storage::AccessStore& store, const std::string& prefix,
                                  const std::function<bool(std::size_t)>& enough) {
  std::vector<double> times;
  while (!enough(times.size())) {
    const auto began = Clock::now();
    MOTIONDB_RETURN_IF_ERROR(store.AddToken({.id = fmt::format("{} {}", prefix, times.size())}));
    times.push_back(1000 * Seconds(Clock::now() - began));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::ranges::sort(times);
  return Times{times[times.size() / 2], times[times.size() * 99 / 100]};
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  const TemporaryDirectory directory;
  const auto parallel = RunOnThreads(options.jobs);
  MOTIONDB_ASSIGN_OR_RETURN(auto clips, VariedClips(DataDir(), options.size, kSeed, parallel));
  BenchTable table{"writes", {}, {}};
  MOTIONDB_ASSIGN_OR_RETURN(const double synced, SyncedPerSecond(directory / "file", clips));
  for (const int clients : {1, 4}) {
    MOTIONDB_ASSIGN_OR_RETURN(
        const double added,
        AddedPerSecond(directory / fmt::format("{}.db", clients), clips, clients));
    table.rows.push_back(RatioRow(fmt::format("clips added by {} clients", clients), added,
                                  "a file, synced", synced, "/s", NoBar()));
  }
  const std::string path = directory / "model.db";
  MOTIONDB_RETURN_IF_ERROR(MakeClipStore(path, options.size.frame_rate_hz, std::move(clips)));
  MOTIONDB_RETURN_IF_ERROR(RebuildStore(path, parallel).status());
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_ASSIGN_OR_RETURN(const core::Model model, store->ReadModel(kLargeDatabase, parallel));
  MOTIONDB_ASSIGN_OR_RETURN(
      const Times alone,
      TimeChanges(store->access(), "alone", [](std::size_t count) { return count == 300; }));
  std::atomic<bool> stored = false;
  absl::Status put;
  double put_seconds = 0;
  std::jthread writer([&] {
    const auto began = Clock::now();
    for (int i = 0; i < options.models && put.ok(); ++i) {
      put = store->PutModel(kLargeDatabase, model).status();
    }
    put_seconds = Seconds(Clock::now() - began);
    stored = true;
  });
  const auto during = TimeChanges(store->access(), "during",
                                  [&](std::size_t count) { return stored && count > 0; });
  writer.join();
  MOTIONDB_RETURN_IF_ERROR(put);
  MOTIONDB_RETURN_IF_ERROR(during.status());
  table.rows.push_back(RatioRow("a token added while a model is stored, median", during->median,
                                "nothing is stored", alone.median, "ms", NoBar()));
  table.rows.push_back(RatioRow("a token added while a model is stored, p99", during->p99,
                                "nothing is stored", alone.p99, "ms", NoBar()));
  table.notes.push_back(fmt::format(
      "writes: {}; {} clips of {} frames; their model was stored {} times, {:.2f} s each",
      kVariedMotion, options.size.clips, options.size.frames / options.size.clips, options.models,
      put_seconds / options.models));
  return table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  BenchProgram program("Measures the write rates of a store.", "motiondb_bench_writes");
  Options options;
  program.AddSize(options.size);
  program.app()
      .add_option("--models", options.models, "Number of times that the model is stored")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads that make the clips and the model");
  return program.Run(argc, argv, [&] { return Run(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
