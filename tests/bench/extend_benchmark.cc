// Measures how soon a large database can use an ingested clip without a build, and how its model
// then differs from a build of the same clips.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/calibration/model_difference.h"
#include "core/model/model_builder.h"
#include "core/motion/error.h"
#include "server/engine/compute_model.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/operation_registry.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/large_store.h"
#include "tests/support/real_data.h"
#include "tests/support/simulated_executor.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kFramesEach = 500;

struct Options {
  VariedSize size;
  std::string store;
  int added = 40;
  int jobs = 1;
  bool rebuild = false;
};

// The database of a store as in a server after its start, with its model. Works on the calling
// thread.
class ServedDatabase {
 public:
  ServedDatabase(storage::MotionStore& store, const storage::DatabaseRecord& record)
      : operations_(store),
        live_(std::make_shared<server::LiveDatabase>(record.name, record.settings)) {
    options_.extend_from = std::chrono::seconds(0);
    live_->SetLifecycle(std::make_unique<server::ModelLifecycle>(
        *live_, server::LifecycleServices{store, operations_, corruptions_, executor_, options_}));
    live_->lifecycle().LoadStored();
  }

  server::LiveDatabase& live() { return *live_; }
  const server::Snapshot& model() const { return *live_->lifecycle().snapshot(); }

  void Extend() {
    live_->lifecycle().RequestUpdate();
    executor_.RunUntil(executor_.Now());
  }

 private:
  server::EngineOptions options_;
  server::OperationRegistry operations_;
  server::CorruptionLog corruptions_;
  SimulatedExecutor executor_{1};
  const std::shared_ptr<server::LiveDatabase> live_;
};

// Adds clips one by one. Returns the time of each from its storage until the model has it, ms.
absl::StatusOr<std::vector<double>> AddOneByOne(storage::MotionStore& store, ServedDatabase& served,
                                                const Options& options) {
  const VariedSize size{options.added, options.added * kFramesEach, options.size.frame_rate_hz};
  MOTIONDB_ASSIGN_OR_RETURN(auto clips,
                            VariedClips(DataDir(), size, kSeed + 1, RunOnThreads(options.jobs)));
  std::vector<double> milliseconds;
  for (core::BuildInput& clip : clips) {
    clip.clip_id = fmt::format("added {:04}", milliseconds.size());
    std::vector<core::BuildInput> one;
    one.push_back(std::move(clip));
    const auto began = std::chrono::steady_clock::now();
    MOTIONDB_RETURN_IF_ERROR(AddClips(store, std::move(one)));
    served.Extend();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
    milliseconds.push_back(took.count());
    if (served.model().record.added_clip_count != std::ssize(milliseconds)) {
      return absl::InternalError("the model lacks an added clip");
    }
  }
  return milliseconds;
}

// Builds a model of all clips in a server's order.
absl::StatusOr<core::Model> BuildAllClips(storage::MotionStore& store, ServedDatabase& served,
                                          const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto records, server::AllClips(store, served.live().name()));
  std::vector<std::string> ids;
  for (const auto& record : records) ids.push_back(record.id);
  MOTIONDB_ASSIGN_OR_RETURN(auto inputs, server::ReadInputs(store, served.live(), ids, parallel));
  return core::BuildModel(served.live().settings(), served.model().model.marker_set(),
                          std::move(inputs), parallel, nullptr);
}

std::string Describe(const core::ModelDifference& difference) {
  return fmt::format(
      "extend: compared with a build of the same clips: bottom nodes {} and {}, rms distance of "
      "frames from their node's mean {:.4f} and {:.4f}, the same label for {} of {} windows of "
      "added clips, each clip left out",
      difference.bottom_nodes_before, difference.bottom_nodes_after, difference.spread_before,
      difference.spread_after, difference.same_label, difference.windows);
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  const auto parallel = RunOnThreads(options.jobs);
  const TemporaryDirectory directory;
  const std::string path = directory / "large.db";
  if (options.store.empty()) {
    MOTIONDB_RETURN_IF_ERROR(MakeLargeStore(path, options.size, kSeed, parallel).status());
  } else {
    std::filesystem::copy_file(options.store, path);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, store->GetDatabase(kLargeDatabase));
  ServedDatabase served(*store, database);
  const int frames = served.model().model.frame_count();
  const auto clips = served.model().model.clips().size();
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<double> times, AddOneByOne(*store, served, options));
  // The first addition moves the states to a larger buffer.
  const double first = times.front();
  std::sort(times.begin(), times.end());

  BenchTable table{"extend", {}, {}};
  table.rows.push_back(RatioRow(
      fmt::format("a clip of {} frames known in {} frames, the slowest", kFramesEach, frames),
      times.back(), "a second", 1000, "ms", AtMost(1)));
  const auto& record = served.model().record;
  table.notes.push_back(fmt::format(
      "extend: {}; {} clips added to {} one by one without a build: the first after {:.0f} ms, "
      "median {:.0f}; afterwards {:.2f} % of the frames are additions and {:.2f} % are in nodes "
      "that a build would split",
      kVariedMotion, options.added, clips, first, times[times.size() / 2],
      100.0 * record.added_frame_count / record.frame_count, 100 * record.drift_fraction));
  if (options.rebuild) {
    MOTIONDB_ASSIGN_OR_RETURN(const core::Model built, BuildAllClips(*store, served, parallel));
    table.notes.push_back(Describe(core::CompareModels(served.model().model, built, parallel)));
  }
  return table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  BenchProgram program("Measures how soon a large database can use a new clip.",
                       "motiondb_bench_extend");
  Options options;
  program.AddSize(options.size);
  program.app()
      .add_option("--store", options.store, "Work on a copy of this store of motiondb_bench_scale")
      ->type_name("FILE");
  program.app()
      .add_option("--added", options.added, "Number of added clips")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  program.app().add_flag("--rebuild", options.rebuild,
                         "Also build a model of all clips, and compare");
  program.AddJobs(options.jobs, "Threads that create the store");
  return program.Run(argc, argv, [&] { return Run(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
