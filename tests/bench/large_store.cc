#include "tests/bench/large_store.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <fstream>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "server/engine/ingest_rules.h"
#include "server/engine/live_database.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/work/clock.h"
#include "server/engine/work/operation_registry.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/real_data.h"
#include "tests/support/simulated_executor.h"

namespace motiondb::tests {
namespace {

// Times the stages that a build reports. "tree, layer 7" belongs to the stage "tree".
class StageLog {
 public:
  void Enter(std::string_view stage) {
    const std::string_view name = stage.substr(0, stage.find(','));
    if (!stages_.empty() && stages_.back().name == name) return;
    Leave();
    stages_.push_back({std::string(name)});
    entered_ = std::chrono::steady_clock::now();
    entered_processor_ = std::clock();
  }
  void Leave() {
    if (stages_.empty()) return;
    const auto now = std::chrono::steady_clock::now();
    stages_.back().seconds = std::chrono::duration<double>(now - entered_).count();
    stages_.back().processor_seconds =
        static_cast<double>(std::clock() - entered_processor_) / CLOCKS_PER_SEC;
    stages_.back().peak_mb = ProcessMegabytes("VmHWM");
  }
  std::vector<BuildStage> stages() && { return std::move(stages_); }

 private:
  std::vector<BuildStage> stages_;
  std::chrono::steady_clock::time_point entered_;
  std::clock_t entered_processor_ = 0;
};

// Runs work inside RunUntil, with the given threads, in real time.
class LendingExecutor : public SimulatedExecutor {
 public:
  explicit LendingExecutor(core::ParallelFor parallel)
      : SimulatedExecutor(1), parallel_(std::move(parallel)) {}
  Clock::time_point Now() const override { return Clock::now(); }
  core::ParallelFor Parallel(server::Pool) override { return parallel_; }

 private:
  const core::ParallelFor parallel_;
};

}  // namespace

absl::Status AddClips(storage::MotionStore& store, std::vector<core::BuildInput> inputs) {
  for (core::BuildInput& input : inputs) {
    storage::NewClip clip;
    clip.file_bytes = fmt::format("{}: {}\n", input.clip_id, kVariedMotion);
    clip.record = {.database = kLargeDatabase,
                   .id = input.clip_id,
                   .label = input.label(),
                   .subject = input.subject,
                   .file_name = input.clip_id + ".bvh",
                   .frame_count = input.states.frame_count(),
                   .duration_seconds = input.states.frame_count() / input.states.frame_rate_hz,
                   .source_frame_rate_hz = input.states.frame_rate_hz,
                   .leg_length_m = input.states.leg_length_m,
                   .source_report = kVariedMotion,
                   .content_hash = server::ContentHash(clip.file_bytes, ""),
                   .create_time_us = server::NowMicroseconds()};
    clip.states = std::move(input.states);
    MOTIONDB_RETURN_IF_ERROR(store.AddClip(clip).status());
  }
  return absl::OkStatus();
}

absl::Status MakeClipStore(const std::string& path, double frame_rate_hz,
                           std::vector<core::BuildInput> clips) {
  storage::DatabaseRecord record{
      .name = kLargeDatabase,
      .marker_set = server::kStandardMarkerSet,
      .marker_set_text = core::WriteMarkerSetFile(core::StandardScheme()),
      .create_time_us = server::NowMicroseconds()};
  record.settings.frame_rate_hz = frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_RETURN_IF_ERROR(store->CreateDatabase(record));
  return AddClips(*store, std::move(clips));
}

absl::StatusOr<std::vector<BuildStage>> RebuildStore(const std::string& path,
                                                     const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, store->GetDatabase(kLargeDatabase));
  server::EngineOptions options;
  options.rebuild_delay = std::chrono::milliseconds(0);
  server::OperationRegistry operations(*store);
  server::CorruptionLog corruptions;
  LendingExecutor executor(parallel);
  const auto live = std::make_shared<server::LiveDatabase>(record.name, record.settings);
  live->set_scheme(server::MarkerSchemes().Of(record));
  live->SetLifecycle(std::make_unique<server::ModelLifecycle>(
      *live, server::LifecycleServices{*store, operations, corruptions, executor, options}));
  MOTIONDB_ASSIGN_OR_RETURN(const auto requested, live->lifecycle().Request());
  StageLog log;
  std::atomic<bool> is_over = false;
  std::thread watch([&] {
    for (; !is_over; std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
      const auto now = operations.Get(requested.id);
      if (now.ok() && now->state == storage::OperationState::kRunning) log.Enter(now->stage);
    }
  });
  executor.RunUntil(server::Executor::Clock::time_point::max());
  is_over = true;
  watch.join();
  MOTIONDB_ASSIGN_OR_RETURN(const auto ended, operations.Get(requested.id));
  if (ended.state != storage::OperationState::kSucceeded) {
    return absl::InternalError("the build failed: " + ended.error_message);
  }
  log.Leave();
  return std::move(log).stages();
}

absl::StatusOr<std::vector<BuildStage>> MakeLargeStore(const std::string& path,
                                                       const VariedSize& size, std::uint64_t seed,
                                                       const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(auto clips, VariedClips(DataDir(), size, seed, parallel));
  MOTIONDB_RETURN_IF_ERROR(MakeClipStore(path, size.frame_rate_hz, std::move(clips)));
  return RebuildStore(path, parallel);
}

double ProcessMegabytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  std::string name;
  for (double kilobytes = 0; status >> name;) {
    if (name == field + ":" && status >> kilobytes) return 1024 * kilobytes / 1e6;
  }
  return 0;
}

}  // namespace motiondb::tests
